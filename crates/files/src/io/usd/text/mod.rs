//! Reads a USD layer from text (`.usda`).

mod tokens;

use std::rc::Rc;

use super::super::IoError;
use super::Budget;
use super::layer::{Arc, ArcKind, ArcList, ListOp, PrimSpec, Value, is_used};
use tokens::Tokens;

/// Most prims inside each other.
const DEEPEST: usize = 128;
/// Estimated memory in bytes of a prim and of a property, without values.
const PRIM: usize = 512;
const PROPERTY: usize = 256;
/// Words before a name that say how a list is combined with the lists of weaker layers.
const LIST_WORDS: [&[u8]; 5] = [b"prepend", b"append", b"add", b"delete", b"reorder"];

/// Reads the prim without a name that holds the layer's metadata and its prims.
pub(super) fn read(bytes: &[u8], budget: &mut Budget) -> Result<PrimSpec, IoError> {
    let mut reader = Reader {
        tokens: Tokens::new(bytes, budget.format),
        budget,
        is_single: false,
    };
    let mut layer = PrimSpec::default();
    if reader.tokens.accept(b'(') {
        reader.metadata(&mut layer)?;
    }
    while reader.tokens.peek().is_some() {
        let word = reader.tokens.word();
        match word {
            b"def" | b"over" | b"class" => reader.prim(word, &mut layer, 0)?,
            b"reorder" => {
                reader.tokens.word();
                reader.tokens.expect(b'=')?;
                reader.value()?;
            }
            _ => return Err(reader.tokens.unexpected("a prim")),
        }
    }
    Ok(layer)
}

struct Reader<'a, 'b> {
    tokens: Tokens<'a>,
    budget: &'b mut Budget,
    /// Whether the numbers of the property that is read are 32-bit floats.
    is_single: bool,
}

impl Reader<'_, '_> {
    /// A prim after its specifier.
    fn prim(
        &mut self,
        specifier: &[u8],
        parent: &mut PrimSpec,
        depth: usize,
    ) -> Result<(), IoError> {
        self.budget.spend(PRIM)?;
        if depth > DEEPEST {
            return Err(self.tokens.fault(format!(
                "prims are more than {DEEPEST} deep inside each other"
            )));
        }
        let mut prim = PrimSpec {
            specifier: lossy(specifier),
            ..PrimSpec::default()
        };
        if self.tokens.peek() != Some(b'"') && self.tokens.peek() != Some(b'\'') {
            prim.kind = lossy(self.tokens.word());
        }
        prim.name = self.tokens.string()?;
        if self.tokens.accept(b'(') {
            self.metadata(&mut prim)?;
        }
        self.body(&mut prim, depth)?;
        parent.children.push(Rc::new(prim));
        Ok(())
    }

    /// What is between the braces of a prim or a variant.
    fn body(&mut self, prim: &mut PrimSpec, depth: usize) -> Result<(), IoError> {
        self.tokens.expect(b'{')?;
        while !self.tokens.accept(b'}') {
            if self.tokens.accept(b';') {
                continue;
            }
            let start = self.tokens.position();
            let word = self.tokens.word();
            match word {
                b"def" | b"over" | b"class" => self.prim(word, prim, depth + 1)?,
                b"variantSet" => self.variants(prim, depth)?,
                b"" => return Err(self.tokens.unexpected("a property, a prim or '}'")),
                _ => {
                    self.tokens.go_to(start);
                    self.property(prim)?;
                }
            }
        }
        Ok(())
    }

    /// The variants of a set, after `variantSet`.
    fn variants(&mut self, prim: &mut PrimSpec, depth: usize) -> Result<(), IoError> {
        let set = self.tokens.string()?;
        self.tokens.expect(b'=')?;
        self.tokens.expect(b'{')?;
        while !self.tokens.accept(b'}') {
            self.budget.spend(PRIM)?;
            if depth > DEEPEST {
                return Err(self
                    .tokens
                    .fault("variants are too deep inside each other".to_owned()));
            }
            let name = self.tokens.string()?;
            let mut variant = PrimSpec::default();
            if self.tokens.accept(b'(') {
                self.metadata(&mut variant)?;
            }
            self.body(&mut variant, depth + 1)?;
            prim.variants.push((set.clone(), name, Rc::new(variant)));
        }
        Ok(())
    }

    /// An attribute, a relationship, or an order of names.
    fn property(&mut self, prim: &mut PrimSpec) -> Result<(), IoError> {
        self.budget.spend(PROPERTY)?;
        let mut word = self.tokens.word();
        let is_order = word == b"reorder";
        let mut is_deleted = false;
        while [&b"custom"[..], b"uniform", b"varying", b"config"].contains(&word)
            || LIST_WORDS.contains(&word)
        {
            is_deleted |= word == b"delete";
            word = self.tokens.word();
        }
        if is_order && matches!(word, b"nameChildren" | b"properties") {
            self.tokens.expect(b'=')?;
            self.value()?;
            return Ok(());
        }
        let is_relationship = word == b"rel";
        let mut kind = lossy(word);
        if self.tokens.accept(b'[') {
            self.tokens.expect(b']')?;
            kind += "[]";
        }
        let name = lossy(self.tokens.word());
        if name.is_empty() || kind.is_empty() {
            return Err(self.tokens.unexpected("the name of a property"));
        }
        let (name, suffix) = match name.rsplit_once('.') {
            Some((name, suffix)) => (name, suffix),
            None => (&name[..], ""),
        };
        let mut property = prim.properties.remove(name).unwrap_or_default();
        if !is_relationship {
            self.is_single = is_single(&kind);
            property.kind = kind;
        }
        if self.tokens.accept(b'=') {
            match suffix {
                "timeSamples" => property.sample = self.first_sample()?,
                "" if !is_relationship && is_used(name) => property.value = Some(self.value()?),
                "" if is_relationship && !is_deleted => {
                    property.targets = self.value()?.texts().to_vec()
                }
                _ => _ = self.value()?,
            }
        }
        self.is_single = false;
        if self.tokens.accept(b'(') {
            let mut about = PrimSpec::default();
            self.metadata(&mut about)?;
            property.interpolation = about
                .text("interpolation")
                .map(str::to_owned)
                .or(property.interpolation);
            property.element_size = about.number("elementSize").or(property.element_size);
            property.unauthored = about
                .number("unauthoredValuesIndex")
                .or(property.unauthored);
        }
        prim.properties.insert(name.to_owned(), property);
        Ok(())
    }

    /// The first value of a dictionary of values by times.
    fn first_sample(&mut self) -> Result<Option<Value>, IoError> {
        let mut first = None;
        self.tokens.expect(b'{')?;
        while !self.tokens.accept(b'}') {
            let time = self.tokens.number()?;
            self.tokens.expect(b':')?;
            let value = self.value()?;
            if first.as_ref().is_none_or(|(known, _)| time < *known) {
                first = Some((time, value));
            }
            self.tokens.accept(b',');
        }
        Ok(first.map(|(_, value)| value))
    }

    /// Metadata up to the closing parenthesis.
    fn metadata(&mut self, of: &mut PrimSpec) -> Result<(), IoError> {
        while !self.tokens.accept(b')') {
            if self.tokens.accept(b';') || self.tokens.accept(b',') {
                continue;
            }
            if matches!(self.tokens.peek(), Some(b'"' | b'\'')) {
                self.tokens.string()?;
                continue;
            }
            let mut word = self.tokens.word();
            let mut op = Some(ListOp::Explicit);
            if LIST_WORDS.contains(&word) {
                op = match word {
                    b"prepend" => Some(ListOp::Prepend),
                    b"delete" => Some(ListOp::Delete),
                    b"reorder" => None,
                    _ => Some(ListOp::Append),
                };
                word = self.tokens.word();
            }
            if word.is_empty() {
                return Err(self.tokens.unexpected("metadata or ')'"));
            }
            self.tokens.expect(b'=')?;
            let name = lossy(word);
            match (&name[..], ArcKind::of_field(&name)) {
                (_, Some(kind)) => {
                    let items = self.arcs()?;
                    of.arcs.extend(op.map(|op| ArcList { kind, op, items }));
                }
                ("variants", _) => self.selection(of)?,
                _ => {
                    let value = self.value()?;
                    of.metadata.insert(name, value);
                }
            }
        }
        Ok(())
    }

    /// The chosen variants: `{ string set = "name" }`.
    fn selection(&mut self, of: &mut PrimSpec) -> Result<(), IoError> {
        self.tokens.expect(b'{')?;
        while !self.tokens.accept(b'}') {
            if self.tokens.accept(b';') || self.tokens.accept(b',') {
                continue;
            }
            if self.tokens.word().is_empty() {
                return Err(self.tokens.unexpected("a set of variants"));
            }
            let set = match self.tokens.peek() {
                Some(b'"' | b'\'') => self.tokens.string()?,
                _ => lossy(self.tokens.word()),
            };
            self.tokens.expect(b'=')?;
            let name = self.tokens.string()?;
            of.selection.insert(set, name);
        }
        Ok(())
    }

    /// References: one or a list of a file, a prim of it, or both, each with an offset in time that is not needed.
    fn arcs(&mut self) -> Result<Vec<Arc>, IoError> {
        let is_list = self.tokens.accept(b'[');
        let mut arcs = Vec::new();
        loop {
            match self.tokens.peek() {
                Some(b'@') => {
                    let asset = self.tokens.asset()?;
                    let has_path = self.tokens.peek() == Some(b'<');
                    let path = if has_path {
                        self.tokens.path()?
                    } else {
                        String::new()
                    };
                    arcs.push(Arc { asset, path });
                }
                Some(b'<') => {
                    let path = self.tokens.path()?;
                    arcs.push(Arc {
                        asset: String::new(),
                        path,
                    });
                }
                Some(b']') if is_list => {}
                _ if self.tokens.word() == b"None" => {}
                _ => return Err(self.tokens.unexpected("a file or a path")),
            }
            if self.tokens.accept(b'(') {
                self.skip_parentheses()?;
            }
            match is_list {
                false => return Ok(arcs),
                true if self.tokens.accept(b']') => return Ok(arcs),
                true => _ = self.tokens.accept(b','),
            }
        }
    }

    /// Skips the offset in time and the data behind a reference, up to the closing parenthesis.
    fn skip_parentheses(&mut self) -> Result<(), IoError> {
        let mut depth = 1usize;
        while depth > 0 {
            match self.tokens.peek() {
                Some(b'"' | b'\'') => _ = self.tokens.string()?,
                Some(b'@') => _ = self.tokens.asset()?,
                Some(b'<') => _ = self.tokens.path()?,
                Some(b) => {
                    depth += usize::from(b == b'(');
                    depth -= usize::from(b == b')');
                    if self.tokens.word().is_empty() {
                        self.tokens.accept(b);
                    }
                }
                None => return Err(self.tokens.unexpected("')'")),
            }
        }
        Ok(())
    }

    /// A value: a number, a text, or a list or tuple of these, which are flattened. Dictionaries are skipped.
    fn value(&mut self) -> Result<Value, IoError> {
        let (mut numbers, mut texts) = (Vec::new(), Vec::new());
        let mut open: Vec<u8> = Vec::new();
        loop {
            match self.tokens.peek() {
                Some(b @ (b'[' | b'(' | b'{')) => {
                    self.tokens.accept(b);
                    open.push(b);
                }
                Some(b @ (b']' | b')' | b'}')) if !open.is_empty() => {
                    let opening = if b == b')' { b'(' } else { b - 2 };
                    if open.pop() != Some(opening) {
                        return Err(self.tokens.unexpected("the bracket that fits"));
                    }
                    self.tokens.accept(b);
                }
                Some(b @ (b',' | b';' | b':' | b'=')) if !open.is_empty() => {
                    _ = self.tokens.accept(b)
                }
                Some(b'"' | b'\'') => texts.push(self.tokens.string()?),
                Some(b'@') => texts.push(self.tokens.asset()?),
                Some(b'<') => texts.push(self.tokens.path()?),
                Some(_) => match self.tokens.word() {
                    b"" => return Err(self.tokens.unexpected("a value")),
                    b"None" => {}
                    b"true" => numbers.push(1.0),
                    b"false" => numbers.push(0.0),
                    word => match super::super::text::number(word) {
                        Some(number) if self.is_single => numbers.push(f64::from(number as f32)),
                        Some(number) => numbers.push(number),
                        // Only dictionaries have names.
                        None if open.contains(&b'{') => {}
                        None => {
                            let what =
                                format!("{} is not a value", super::super::text::shown(word));
                            return Err(self.tokens.fault(what));
                        }
                    },
                },
                None => return Err(self.tokens.unexpected("a value")),
            }
            if open.is_empty() {
                break;
            }
        }
        self.budget.spend(8 * numbers.len() + 32 * texts.len())?;
        Ok(match (numbers.is_empty(), texts.is_empty()) {
            (false, true) => Value::Numbers(Rc::new(numbers)),
            (true, false) => Value::Texts(Rc::new(texts)),
            _ => Value::Other,
        })
    }
}

/// Whether the numbers of a type are floats of 32 or 16 bits, for example of `float3` and `quath`.
fn is_single(kind: &str) -> bool {
    let kind = kind.strip_suffix("[]").unwrap_or(kind);
    kind.starts_with("float") || kind.starts_with("half") || kind.ends_with(['f', 'h'])
}

fn lossy(word: &[u8]) -> String {
    String::from_utf8_lossy(word).into_owned()
}
