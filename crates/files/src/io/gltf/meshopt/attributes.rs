//! Decodes the mode `ATTRIBUTES` of `EXT_meshopt_compression`: elements as differences of bytes to the element before.
//!
//! Source: the extension's specification, appendix A, mode 0.

/// The first byte of a stream.
const HEADER: u8 = 0xa0;
/// Number of differences that are stored together.
const GROUP: usize = 16;
/// Bytes. Least size of the end of a stream, which holds the element before the first one.
const LEAST_TAIL: usize = 32;

/// Decodes `count` elements of `stride` bytes each; `None` for a damaged stream.
pub(super) fn decoded(bytes: &[u8], count: usize, stride: usize) -> Option<Vec<u8>> {
    let (head, rest) = bytes.split_first()?;
    let body = rest.len().checked_sub(stride.max(LEAST_TAIL))?;
    let (mut body, tail) = rest.split_at(body);
    if *head != HEADER {
        return None;
    }
    let mut before = tail[tail.len() - stride..].to_vec();
    let mut out = vec![0; count.checked_mul(stride)?];
    for block in out.chunks_mut(stride * block_elements(stride)) {
        for (place, before) in before.iter_mut().enumerate() {
            body = bytes_of_block(body, block, place, stride, before)?;
        }
    }
    body.is_empty().then_some(out)
}

/// The number of elements of a block, but for the last one.
pub(super) fn block_elements(stride: usize) -> usize {
    ((8192 / stride) & !(GROUP - 1)).min(256)
}

/// Decodes one byte of each element of a block; `before` is this byte of the element before the block, and then of its last one.
/// Returns the rest of the stream.
fn bytes_of_block<'a>(
    body: &'a [u8],
    block: &mut [u8],
    place: usize,
    stride: usize,
    before: &mut u8,
) -> Option<&'a [u8]> {
    let groups = (block.len() / stride).div_ceil(GROUP);
    let (modes, mut body) = body.split_at_checked(groups.div_ceil(4))?;
    for (number, group) in block.chunks_mut(GROUP * stride).enumerate() {
        let mode = modes[number / 4] >> (2 * (number % 4)) & 3;
        let (differences, rest) = group_of(mode, body)?;
        body = rest;
        for (element, difference) in group.chunks_mut(stride).zip(differences) {
            *before = before.wrapping_add(unzigzag(difference));
            element[place] = *before;
        }
    }
    Some(body)
}

/// The 16 differences of a group, and the rest of the stream.
fn group_of(mode: u8, body: &[u8]) -> Option<([u8; GROUP], &[u8])> {
    let bits = match mode {
        0 => return Some(([0; GROUP], body)),
        1 => 2,
        2 => 4,
        _ => {
            let (all, rest) = body.split_first_chunk::<GROUP>()?;
            return Some((*all, rest));
        }
    };
    // The first difference of a byte is in its highest bits. The largest value stands for a byte that follows the group.
    let (packed, mut rest) = body.split_at_checked(GROUP * bits / 8)?;
    let largest = (1 << bits) - 1;
    let mut differences = [0; GROUP];
    for (number, difference) in differences.iter_mut().enumerate() {
        let at = number * bits;
        *difference = packed[at / 8] >> (8 - bits - at % 8) & largest;
        if *difference == largest {
            let (byte, after) = rest.split_first()?;
            (*difference, rest) = (*byte, after);
        }
    }
    Some((differences, rest))
}

/// A signed difference from its form with the sign in the lowest bit.
fn unzigzag(value: u8) -> u8 {
    (value >> 1) ^ (value & 1).wrapping_neg()
}
