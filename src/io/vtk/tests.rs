use super::super::samples::*;
