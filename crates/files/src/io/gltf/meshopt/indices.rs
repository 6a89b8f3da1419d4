//! Decodes the modes `TRIANGLES` and `INDICES` of `EXT_meshopt_compression`.
//!
//! Source: the extension's specification, appendix A, modes 1 and 2.

/// The first bytes of streams of triangles and of indices.
const TRIANGLES: u8 = 0xe1;
const INDICES: u8 = 0xd1;
/// Bytes. Size of the table at the end of a stream of triangles, and of the end of a stream of indices.
const TABLE: usize = 16;
const TAIL: usize = 4;

/// Decodes the indices of triangles, three for each; `None` for a damaged stream.
pub(super) fn triangles(bytes: &[u8], count: usize) -> Option<Vec<u32>> {
    let (head, rest) = bytes.split_first()?;
    let (codes, rest) = rest.split_at_checked(count / 3)?;
    let data = rest.len().checked_sub(TABLE)?;
    let (data, table) = rest.split_at(data);
    if *head != TRIANGLES || !count.is_multiple_of(3) {
        return None;
    }
    let mut state = State {
        data,
        next: 0,
        last: 0,
        edges: Recent::default(),
        vertices: Recent::default(),
    };
    let mut out = Vec::with_capacity(count);
    for &code in codes {
        out.extend(match code {
            0..0xf0 => state.beside_edge(code >> 4, code & 15)?,
            0xf0..0xfe => state.listed(table[usize::from(code & 15)]),
            0xfe.. => state.explicit(code == 0xff)?,
        });
    }
    state.data.is_empty().then_some(out)
}

/// Decodes indices that make no triangles; `None` for a damaged stream.
pub(super) fn sequence(bytes: &[u8], count: usize) -> Option<Vec<u32>> {
    let (head, rest) = bytes.split_first()?;
    let body = rest.len().checked_sub(TAIL)?;
    let mut data = &rest[..body];
    // Each index takes a byte at least.
    if *head != INDICES || count > body {
        return None;
    }
    let mut last = [0u32; 2];
    let mut out = Vec::with_capacity(count);
    for _ in 0..count {
        let value = varint(&mut data)?;
        let last = &mut last[(value & 1) as usize];
        *last = last.wrapping_add(unzigzag(value >> 1));
        out.push(*last);
    }
    data.is_empty().then_some(out)
}

/// The last 16 values.
#[derive(Default)]
struct Recent<T> {
    values: [T; 16],
    end: usize,
}

impl<T: Copy> Recent<T> {
    fn push(&mut self, value: T) {
        self.values[self.end] = value;
        self.end = (self.end + 1) % 16;
    }

    /// The value that was pushed this number of pushes before the last one.
    fn get(&self, back: u8) -> T {
        self.values[(self.end + 15 - usize::from(back)) % 16]
    }
}

/// What a decoder of triangles knows.
struct State<'a> {
    /// Data beyond the codes that is not read yet.
    data: &'a [u8],
    /// The next vertex that no triangle has used.
    next: u32,
    /// The last index that was given explicitly.
    last: u32,
    edges: Recent<(u32, u32)>,
    vertices: Recent<u32>,
}

impl State<'_> {
    /// A triangle at a recent edge; `third` says where its third vertex is.
    fn beside_edge(&mut self, edge: u8, third: u8) -> Option<[u32; 3]> {
        let (a, b) = self.edges.get(edge);
        let c = match third {
            0 => self.next_vertex(),
            1..0xd => self.vertices.get(third),
            0xd => self.set_last(self.last.wrapping_sub(1)),
            0xe => self.set_last(self.last.wrapping_add(1)),
            _ => self.index()?,
        };
        // Recent vertices stay where they are.
        if !(1..0xd).contains(&third) {
            self.vertices.push(c);
        }
        self.edges.push((c, b));
        self.edges.push((a, c));
        Some([a, b, c])
    }

    /// A triangle of a new vertex and two that are new or recent, as an entry of the table says.
    fn listed(&mut self, entry: u8) -> [u32; 3] {
        let a = self.next_vertex();
        let [b, c] = [entry >> 4, entry & 15].map(|part| match part {
            0 => self.next_vertex(),
            back => self.vertices.get(back - 1),
        });
        self.finished([a, b, c], [true, entry >> 4 == 0, entry & 15 == 0])
    }

    /// A triangle whose vertices a byte of the data describes: new, recent or given.
    fn explicit(&mut self, first_is_given: bool) -> Option<[u32; 3]> {
        let entry = self.byte()?;
        if entry == 0 {
            // A stream that was appended begins to count again.
            self.next = 0;
        }
        let parts = [entry >> 4, entry & 15];
        // New and recent vertices come before the given ones, which the data lists in order.
        let mut corners = [0; 3];
        if !first_is_given {
            corners[0] = self.next_vertex();
        }
        for (corner, part) in corners[1..].iter_mut().zip(parts) {
            *corner = match part {
                0 => self.next_vertex(),
                15 => 0,
                back => self.vertices.get(back - 1),
            };
        }
        if first_is_given {
            corners[0] = self.index()?;
        }
        for (at, part) in parts.into_iter().enumerate() {
            if part == 15 {
                corners[at + 1] = self.index()?;
            }
        }
        let is_pushed = |part: u8| part == 0 || part == 15;
        Some(self.finished(corners, [true, is_pushed(parts[0]), is_pushed(parts[1])]))
    }

    /// Remembers the edges of a triangle, and its marked vertices.
    fn finished(&mut self, [a, b, c]: [u32; 3], are_pushed: [bool; 3]) -> [u32; 3] {
        for (vertex, is_pushed) in [a, b, c].into_iter().zip(are_pushed) {
            if is_pushed {
                self.vertices.push(vertex);
            }
        }
        for edge in [(b, a), (c, b), (a, c)] {
            self.edges.push(edge);
        }
        [a, b, c]
    }

    fn next_vertex(&mut self) -> u32 {
        let next = self.next;
        self.next = next.wrapping_add(1);
        next
    }

    /// An index from the data, stored as its difference from the last one.
    fn index(&mut self) -> Option<u32> {
        let difference = unzigzag(varint(&mut self.data)?);
        Some(self.set_last(self.last.wrapping_add(difference)))
    }

    fn set_last(&mut self, index: u32) -> u32 {
        self.last = index;
        index
    }

    fn byte(&mut self) -> Option<u8> {
        let (byte, rest) = self.data.split_first()?;
        self.data = rest;
        Some(*byte)
    }
}

/// Reads an unsigned number: 7 bits of each byte, the lowest first; the highest bit says that another byte follows.
fn varint(data: &mut &[u8]) -> Option<u32> {
    let mut value = 0u32;
    for shift in (0..35).step_by(7) {
        let (byte, rest) = data.split_first()?;
        *data = rest;
        value |= u32::from(byte & 127) << shift;
        if *byte < 128 {
            return Some(value);
        }
    }
    None
}

/// A signed difference from its form with the sign in the lowest bit.
fn unzigzag(value: u32) -> u32 {
    (value >> 1) ^ (value & 1).wrapping_neg()
}
