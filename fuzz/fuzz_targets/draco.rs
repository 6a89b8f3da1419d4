#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| isomend_fuzz::draco(data));
