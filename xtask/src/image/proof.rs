//! What is shown of an image before it drives a motor: no interrupt or fault handler can panic, the stack is never too small and
//! overflows into nothing, and there is no heap that could leak.

use std::collections::BTreeMap;
use std::fmt;

use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, elf};

use super::graph::Graph;

/// Where RAM begins on every board.
const RAM: u64 = 0x2000_0000;
/// What the core pushes before a handler runs: 26 words with the floating-point registers and one to align (ARMv7-M Architecture
/// Reference Manual B1.5.7); without them it is less.
const EXCEPTION_FRAME: u32 = 4 * 27;
/// Words of the vector table: Reset, the NMI; the handlers of all else follow.
const RESET: usize = 1;
const NMI: usize = 2;

/// What was shown.
#[derive(Debug)]
pub struct Proof {
    /// Handlers of interrupts and faults, none of which can reach a panic.
    pub handlers: usize,
    /// The stack that the program can need at most, bytes.
    pub deepest: u32,
    /// The stack that it has, bytes.
    pub stack: u32,
}

impl fmt::Display for Proof {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Proof { handlers, deepest, stack } = self;
        write!(f, "{handlers} handlers without a panic, stack at most {deepest} of {stack} bytes")
    }
}

/// Proves it, or says what is in the way.
///
/// # Errors
/// When anything of it does not hold.
pub fn prove(bytes: &[u8]) -> Result<Proof> {
    let file = object::File::parse(bytes)?;
    let graph = Graph::read(bytes)?;
    let (reset, nmi, handlers) = roots(&file)?;
    let all: Vec<u32> = handlers.iter().chain([&nmi]).copied().collect();
    no_panic(&graph, &all)?;
    no_heap(&file)?;
    let stack = stack_below_data(&file)?;
    let mut worst = 0;
    for handler in &handlers {
        worst = worst.max(graph.deepest(*handler)?.0);
    }
    // All interrupts have one priority, so that none interrupts another; the NMI interrupts all. A fault begins another stack.
    let (main, chain) = graph.deepest(reset)?;
    let deepest = main + EXCEPTION_FRAME + worst + EXCEPTION_FRAME + graph.deepest(nmi)?.0;
    if deepest > stack {
        let chain: Vec<String> = chain.iter().map(|address| graph.name(*address)).collect();
        bail!("the stack of {stack} bytes is too small: {deepest} by {}", chain.join(" > "));
    }
    Ok(Proof { handlers: all.len(), deepest, stack })
}

/// Reset's handler, the NMI's, and each other of the vector table.
fn roots(file: &object::File<'_>) -> Result<(u32, u32, Vec<u32>)> {
    let table = file.section_by_name(".vector_table").context("the image has no vector table")?;
    let words: Vec<u32> = table
        .data()?
        .chunks_exact(4)
        .map(|word| u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
        .collect();
    let handler = |place: usize| words.get(place).map(|word| word & !1).context("a short vector table");
    let mut others: Vec<u32> =
        words.iter().skip(NMI + 1).filter(|word| **word != 0).map(|word| word & !1).collect();
    others.sort_unstable();
    others.dedup();
    Ok((handler(RESET)?, handler(NMI)?, others))
}

/// Fails when a handler reaches a panic, or calls through a register what nobody can name.
fn no_panic(graph: &Graph, handlers: &[u32]) -> Result<()> {
    let reached = graph.reached(handlers)?;
    for address in reached.keys() {
        let name = graph.name(*address);
        let panics = name.starts_with("core::panicking") || name.contains("rust_begin_unwind");
        if panics || graph.functions[address].facts.indirect > 0 {
            let what = if panics { "panics" } else { "calls through a register" };
            bail!("an interrupt's handler {what}: {}", way(graph, &reached, *address));
        }
    }
    Ok(())
}

/// How a function was reached.
fn way(graph: &Graph, reached: &BTreeMap<u32, u32>, to: u32) -> String {
    let mut at = to;
    let mut names = vec![graph.name(at)];
    while let Some(from) = reached.get(&at).filter(|from| **from != at) {
        at = *from;
        names.push(graph.name(at));
    }
    names.reverse();
    names.join(" > ")
}

/// Fails when the image has an allocator.
fn no_heap(file: &object::File<'_>) -> Result<()> {
    let found = file.symbols().find_map(|symbol| {
        let name = symbol.name().ok()?;
        name.contains("__rust_alloc").then(|| name.to_owned())
    });
    ensure!(found.is_none(), "the image has a heap: {found:?}");
    Ok(())
}

/// The stack's size, when it is the lowest of the RAM and everything else in it lies above.
fn stack_below_data(file: &object::File<'_>) -> Result<u32> {
    let symbol = |name: &str| {
        let found = file.symbols().find(|symbol| symbol.name() == Ok(name));
        found.map(|symbol| symbol.address()).with_context(|| format!("the image has no {name}"))
    };
    let (top, end) = (symbol("_stack_start")?, symbol("_stack_end")?);
    ensure!(end == RAM, "the stack ends at {end:#x}, above other memory");
    for section in file.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
        let written = sh_flags & u64::from(elf::SHF_ALLOC | elf::SHF_WRITE);
        let in_ram = section.address() >= RAM && section.size() > 0;
        if written == u64::from(elf::SHF_ALLOC | elf::SHF_WRITE) && in_ram {
            let name = section.name().unwrap_or_default();
            ensure!(section.address() >= top, "{name} lies in or below the stack");
        }
    }
    Ok((top - end) as u32)
}
