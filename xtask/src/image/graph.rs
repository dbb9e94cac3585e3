//! An image's functions, and which calls which.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSection, ObjectSymbol, SectionKind, SymbolKind};

use super::thumb::{self, Facts};

/// Functions of core's sort that call themselves, and how deep at most, for a population of up to 64 chromosomes: quicksort goes over
/// to heapsort below twice the logarithm of the length, and the pivot is sought in eighths, of eighths where those have eight elements.
const NESTED: [(&str, u32); 2] = [
    ("core::slice::sort::unstable::quicksort::quicksort", 2 * 6 + 1),
    ("core::slice::sort::shared::pivot::median3_rec", 2),
];

/// A function of the image.
#[derive(Debug)]
pub struct Function {
    /// Its names; those that are the same code share it.
    pub names: Vec<String>,
    /// What its instructions do.
    pub facts: Facts,
}

/// The functions by their address, without the bit that says Thumb.
#[derive(Debug)]
pub struct Graph {
    /// All of them.
    pub functions: BTreeMap<u32, Function>,
    /// Those whose address stands somewhere in the image, so that a call through a register can come to them.
    taken: Vec<u32>,
}

impl Graph {
    /// Reads an ELF file with symbols.
    ///
    /// # Errors
    /// When it is none, or has code without symbols.
    pub fn read(elf: &[u8]) -> Result<Self> {
        let file = object::File::parse(elf)?;
        let mut ranges: BTreeMap<u32, (u64, Vec<String>)> = BTreeMap::new();
        // Where code and data begin in the text: $t and $d (ELF for the Arm Architecture, 4.5.5).
        let mut marks: BTreeMap<u32, bool> = BTreeMap::new();
        for symbol in file.symbols() {
            let name = symbol.name().unwrap_or_default();
            if name.starts_with("$d") || name.starts_with("$t") {
                marks.insert(symbol.address() as u32, name.starts_with("$d"));
            } else if symbol.kind() == SymbolKind::Text && symbol.is_definition() {
                let entry = ranges.entry(symbol.address() as u32 & !1).or_default();
                entry.0 = entry.0.max(symbol.size());
                entry.1.push(name.to_owned());
            }
        }
        let data = |address: u32| marks.range(..=address).next_back().is_some_and(|(_, data)| *data);
        let texts: Vec<_> = file.sections().filter(|section| section.kind() == SectionKind::Text).collect();
        let starts: Vec<u32> = ranges.keys().copied().collect();
        let mut functions = BTreeMap::new();
        for (place, (start, (size, names))) in ranges.into_iter().enumerate() {
            let holds = |section: &&object::Section<'_, '_>| {
                (section.address()..section.address() + section.size()).contains(&u64::from(start))
            };
            let Some(section) = texts.iter().find(holds) else { continue };
            let rest = section.address() + section.size() - u64::from(start);
            // Functions written in assembly may not tell their size: they end where the next begins.
            let next = starts.get(place + 1).map_or(rest, |next| u64::from(next - start));
            let size = if size == 0 { next.min(rest) } else { size };
            let code = section
                .data_range(start.into(), size)?
                .with_context(|| format!("{names:?} reaches beyond its section"))?;
            functions.insert(start, Function { names, facts: thumb::read(code, start, data) });
        }
        ensure!(!functions.is_empty(), "the image has no functions");
        let taken = taken(&file, &functions)?;
        Ok(Graph { functions, taken })
    }

    /// The functions that one calls or ends in. Through a register any can be called whose address is taken.
    ///
    /// # Errors
    /// When it calls what is no function's begin.
    pub fn called(&self, caller: u32) -> Result<Vec<u32>> {
        let function = &self.functions[&caller];
        let mut called = function.facts.calls.clone();
        if function.facts.indirect > 0 {
            called.extend(&self.taken);
        }
        for target in &called {
            if !self.functions.contains_key(target) {
                bail!("{} calls {target:#x}, where no function begins", self.name(caller));
            }
        }
        Ok(called)
    }

    /// A function's name, as people read it.
    pub fn name(&self, address: u32) -> String {
        let names = self.functions.get(&address).map(|function| function.names.as_slice());
        names
            .and_then(<[_]>::first)
            .map_or_else(|| format!("{address:#x}"), |name| format!("{:#}", rustc_demangle::demangle(name)))
    }

    /// Every function that can be reached from these, each with the one that it was reached from.
    ///
    /// # Errors
    /// As [`Self::called`].
    pub fn reached(&self, roots: &[u32]) -> Result<BTreeMap<u32, u32>> {
        let mut from: BTreeMap<u32, u32> = roots.iter().map(|root| (*root, *root)).collect();
        let mut open = roots.to_vec();
        while let Some(caller) = open.pop() {
            for target in self.called(caller)? {
                from.entry(target).or_insert_with(|| {
                    open.push(target);
                    caller
                });
            }
        }
        Ok(from)
    }

    /// The most stack that a function and all it calls take, in bytes, and the chain that takes it.
    ///
    /// # Errors
    /// When functions call each other in a circle, or move the stack by what only the run knows: then there is no bound.
    pub fn deepest(&self, root: u32) -> Result<(u32, Vec<u32>)> {
        let mut known = BTreeMap::new();
        let depth = self.depth(root, &mut known, &mut Vec::new())?;
        let mut chain = vec![root];
        while let Some(next) = known.get(chain.last().unwrap_or(&root)).and_then(|(_, next)| *next) {
            chain.push(next);
        }
        Ok((depth, chain))
    }

    /// How often a function may stand on the stack at once: once, but for those that are known to end.
    fn nested(&self, address: u32) -> u32 {
        let name = self.name(address);
        NESTED.iter().find(|(its, _)| name.starts_with(its)).map_or(1, |(_, times)| *times)
    }

    fn depth(
        &self,
        address: u32,
        known: &mut BTreeMap<u32, (u32, Option<u32>)>,
        open: &mut Vec<u32>,
    ) -> Result<u32> {
        if let Some((depth, _)) = known.get(&address) {
            return Ok(*depth);
        }
        if open.contains(&address) {
            let names: Vec<String> = open.iter().chain([&address]).map(|its| self.name(*its)).collect();
            bail!("functions call each other in a circle: {}", names.join(" > "));
        }
        let facts = &self.functions[&address].facts;
        ensure!(!facts.unbounded, "{} moves the stack by what only the run knows", self.name(address));
        open.push(address);
        let mut deepest = (0, None);
        let nested = self.nested(address);
        for target in self.called(address)? {
            if nested > 1 && target == address {
                continue;
            }
            let depth = self.depth(target, known, open)?;
            if depth >= deepest.0 {
                deepest = (depth, Some(target));
            }
        }
        open.pop();
        let depth = nested * facts.stack + deepest.0;
        known.insert(address, (depth, deepest.1));
        Ok(depth)
    }
}

/// Functions whose address is a word of the data, or a constant that code makes. The vector table's are not called, but taken over by
/// the core; they are the roots of their own.
fn taken(file: &object::File<'_>, functions: &BTreeMap<u32, Function>) -> Result<Vec<u32>> {
    let mut words: BTreeSet<u32> =
        functions.values().flat_map(|function| function.facts.constants.iter().copied()).collect();
    let constant = [SectionKind::ReadOnlyData, SectionKind::Data, SectionKind::ReadOnlyString];
    for section in file.sections() {
        if constant.contains(&section.kind()) && section.name() != Ok(".vector_table") {
            let bytes = section.data()?;
            words.extend(bytes.chunks_exact(4).map(|w| u32::from_le_bytes([w[0], w[1], w[2], w[3]])));
        }
    }
    Ok(functions.keys().copied().filter(|address| words.contains(&(address | 1))).collect())
}
