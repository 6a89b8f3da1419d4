//! Compressed blocks of the crate format: LZ4 in chunks, and integers as differences of 0 to 8 bytes.

/// Most bytes of a chunk that is decompressed at once.
const CHUNK: usize = 0x7e00_0000;

/// Decompresses a block of at most `most` bytes; `None` if it is damaged or larger.
///
/// The first byte is the number of chunks; without any, one LZ4 block follows, else each is behind its size of 32 bits.
pub(super) fn block(bytes: &[u8], most: usize) -> Option<Vec<u8>> {
    // LZ4 makes at most 255 bytes of one.
    let most = most.min(bytes.len().saturating_mul(255));
    let mut out = vec![0; most];
    let (&chunks, mut rest) = bytes.split_first()?;
    let mut done = 0;
    if chunks == 0 {
        done = lz4_flex::block::decompress_into(rest, &mut out).ok()?;
    }
    for _ in 0..chunks {
        let (size, after) = rest.split_first_chunk::<4>()?;
        let size = usize::try_from(i32::from_le_bytes(*size)).ok()?;
        let (chunk, after) = after.split_at_checked(size)?;
        let room = out.len().min(done.saturating_add(CHUNK));
        done += lz4_flex::block::decompress_into(chunk, &mut out[done..room]).ok()?;
        rest = after;
    }
    out.truncate(done);
    Some(out)
}

/// The bytes that `count` integers of `size` bytes take before LZ4: the most frequent difference, two bits and the difference for each.
pub(super) fn working_size(count: usize, size: usize) -> usize {
    (size + 1).saturating_mul(count).saturating_add(size + 1)
}

/// Decodes `count` integers of 4 or 8 bytes; `None` if the block is damaged.
pub(super) fn decoded(bytes: &[u8], count: usize, size: usize) -> Option<Vec<i64>> {
    let unpacked = block(bytes, working_size(count, size))?;
    let number = |bytes: &[u8]| {
        let mut wide = [if bytes.last().is_some_and(|b| *b >= 128) {
            0xff
        } else {
            0
        }; 8];
        wide[..bytes.len()].copy_from_slice(bytes);
        i64::from_le_bytes(wide)
    };
    let (common, rest) = unpacked.split_at_checked(size)?;
    let common = number(common);
    let (codes, mut rest) = rest.split_at_checked((2 * count).div_ceil(8))?;
    let (mut last, mut out) = (0i64, Vec::with_capacity(count));
    for at in 0..count {
        let code = codes[at / 4] >> (2 * (at % 4)) & 3;
        // Bytes of a difference: none, 1, 2 and 4 of 32-bit integers; none, 2, 4 and 8 of 64-bit ones.
        let length = [0, size / 4, size / 2, size][usize::from(code)];
        let difference = match length {
            0 => common,
            _ => {
                let (own, after) = rest.split_at_checked(length)?;
                rest = after;
                number(own)
            }
        };
        last = last.wrapping_add(difference);
        if size == 4 {
            last = i64::from(last as i32);
        }
        out.push(last);
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_sums_of_differences_of_every_size() {
        // The common difference 1, then codes 0, 1, 2, 3: +1, -2, +300, +100000.
        let mut plain = 1i32.to_le_bytes().to_vec();
        plain.push(0b11_10_01_00);
        plain.push(-2i8 as u8);
        plain.extend(300i16.to_le_bytes());
        plain.extend(100_000i32.to_le_bytes());
        let packed = [&[0][..], &lz4_flex::block::compress(&plain)].concat();
        assert_eq!(decoded(&packed, 4, 4), Some(vec![1, -1, 299, 100_299]));
        assert_eq!(decoded(&packed, 9, 4), None);
        // The same in two chunks.
        let chunk = |bytes: &[u8]| {
            let packed = lz4_flex::block::compress(bytes);
            [&(packed.len() as i32).to_le_bytes()[..], &packed].concat()
        };
        let chunks = [&[2][..], &chunk(&plain[..3]), &chunk(&plain[3..])].concat();
        assert_eq!(decoded(&chunks, 4, 4), Some(vec![1, -1, 299, 100_299]));
        let mut wide = (-7i64).to_le_bytes().to_vec();
        wide.push(0b0100);
        wide.extend(1000i16.to_le_bytes());
        let packed = [&[0][..], &lz4_flex::block::compress(&wide)].concat();
        assert_eq!(decoded(&packed, 2, 8), Some(vec![-7, 993]));
    }
}
