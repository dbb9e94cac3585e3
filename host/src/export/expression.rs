//! Recorded expressions as text: what is used twice gets a name, everything else stands where it is used.

use std::collections::HashMap;

use motorlens_shared::effects::{Kind, Operation, UserDefined};

use super::record::{Input, Node, Recorded, Tape};

/// How a language writes what differs from the others. Sums, products and signs are alike in all.
pub(super) struct Syntax {
    /// The smaller of two.
    pub least: fn(&str, &str) -> String,
    /// The larger of two.
    pub most: fn(&str, &str) -> String,
    /// Where the first is more than the second, the third, else the fourth.
    pub pick: fn([&str; 4]) -> String,
    /// A quotient whose divisor may be zero where it is not needed.
    pub divide: fn(&str, &str) -> Option<String>,
    /// The nearest integer.
    pub round: fn(&str) -> String,
    /// Magnitude.
    pub absolute: fn(&str) -> String,
    /// The voltage so many whole steps back.
    pub past: fn(usize) -> String,
    /// A function of a user's formula.
    pub call: fn(&str, &[String]) -> String,
    /// A number that is none, or too large for one.
    pub not_finite: fn(f64) -> &'static str,
}

/// How tightly the outermost operator of a text binds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Binding {
    Sum,
    /// Not beside another sign: Modelica knows no `a - -b`.
    Sign,
    Product,
    Whole,
}

/// Longer expressions get a name, so that a line can be read.
const LONG: usize = 90;

/// Prints a recording.
pub(super) struct Printer<'a> {
    tape: &'a Tape,
    syntax: &'a Syntax,
    /// Names of the functions that formulas call, by address.
    functions: HashMap<usize, &'static str>,
    names: &'a dyn Fn(Input) -> String,
}

/// Definitions in order, and the text of each output.
pub(super) struct Text {
    pub defined: Vec<(String, String)>,
    pub outputs: Vec<String>,
}

impl<'a> Printer<'a> {
    pub(super) fn new(
        tape: &'a Tape,
        syntax: &'a Syntax,
        effects: &[(Kind, Vec<f64>)],
        names: &'a dyn Fn(Input) -> String,
    ) -> Self {
        let formulas = effects.iter().filter_map(|(kind, _)| match kind {
            Kind::Formula(UserDefined(definition)) => Some(definition.program()),
            _ => None,
        });
        let functions = formulas.flatten().filter_map(|operation| match operation {
            Operation::Function(name, f) => Some((*f as usize, *name)),
            Operation::FunctionOfTwo(name, f) => Some((*f as usize, *name)),
            _ => None,
        });
        Self { tape, syntax, functions: functions.collect(), names }
    }

    /// What `outputs` take to compute.
    pub(super) fn text(&self, outputs: &[Recorded]) -> Text {
        let mut uses = vec![0_usize; self.tape.len()];
        outputs.iter().for_each(|output| uses[output.0] += 1);
        // Arguments stand before what is computed from them.
        for place in (0..self.tape.len()).rev() {
            if uses[place] > 0 {
                self.tape.node(place).arguments().for_each(|argument| uses[argument] += 1);
            }
        }
        let mut defined = Vec::new();
        let mut texts: HashMap<usize, (String, Binding)> = HashMap::new();
        for place in (0..self.tape.len()).filter(|place| uses[*place] > 0) {
            let node = self.tape.node(place);
            let mut text = self.print(node, &texts);
            let leaf = matches!(node, Node::Constant(_) | Node::Input(_));
            if !leaf && (uses[place] > 1 || text.0.len() > LONG) {
                let name = format!("t{}", defined.len() + 1);
                defined.push((name.clone(), text.0));
                text = (name, Binding::Whole);
            }
            texts.insert(place, text);
        }
        Text { defined, outputs: outputs.iter().map(|output| texts[&output.0].0.clone()).collect() }
    }

    fn print(&self, node: Node, texts: &HashMap<usize, (String, Binding)>) -> (String, Binding) {
        let plain = |place: usize| texts[&place].0.as_str();
        let within = |place: usize, least: Binding| {
            let (text, binding) = &texts[&place];
            if *binding < least { format!("({text})") } else { text.clone() }
        };
        let infix = |a: usize, sign: &str, b: usize, [left, right]: [Binding; 2]| {
            format!("{} {sign} {}", within(a, left), within(b, right))
        };
        let (sum, product) = ([Binding::Sum, Binding::Product], [Binding::Product, Binding::Whole]);
        let whole = |text: String| (text, Binding::Whole);
        match node {
            Node::Constant(bits) => self.constant(f64::from_bits(bits)),
            Node::Input(input) => whole((self.names)(input)),
            Node::Add(a, b) => (infix(a, "+", b, sum), Binding::Sum),
            Node::Subtract(a, b) => (infix(a, "-", b, sum), Binding::Sum),
            Node::Multiply(a, b) => (infix(a, "*", b, product), Binding::Product),
            Node::Divide(a, b) => {
                let safe = if matches!(self.tape.node(b), Node::Constant(_)) {
                    None
                } else {
                    (self.syntax.divide)(plain(a), plain(b))
                };
                safe.map_or_else(|| (infix(a, "/", b, product), Binding::Product), whole)
            }
            Node::Negate(a) => (format!("-{}", within(a, Binding::Whole)), Binding::Sign),
            Node::Absolute(a) => whole((self.syntax.absolute)(plain(a))),
            Node::Least(a, b) => whole((self.syntax.least)(plain(a), plain(b))),
            Node::Most(a, b) => whole((self.syntax.most)(plain(a), plain(b))),
            Node::Pick(a, b, x, y) => whole((self.syntax.pick)([plain(a), plain(b), plain(x), plain(y)])),
            Node::Round(a) => whole((self.syntax.round)(plain(a))),
            Node::Back(a) => self.back(a),
            Node::Call(f, a) => whole((self.syntax.call)(self.function(f), &[plain(a).to_owned()])),
            Node::CallOfTwo(f, a, b) => {
                whole((self.syntax.call)(self.function(f), &[plain(a).to_owned(), plain(b).to_owned()]))
            }
        }
    }

    /// A delay is a parameter, so it is known: between which two voltages, and where.
    fn back(&self, steps: usize) -> (String, Binding) {
        let Node::Constant(bits) = self.tape.node(steps) else {
            unreachable!("a delay that changes while it runs is no effect of the library")
        };
        let steps = f64::from_bits(bits).max(0.0);
        let (whole, part) = (steps as usize, steps.fract());
        let (newer, older) = ((self.syntax.past)(whole), (self.syntax.past)(whole + 1));
        if part == 0.0 {
            return (newer, Binding::Whole);
        }
        (format!("{newer} + {part:?} * ({older} - {newer})"), Binding::Sum)
    }

    fn constant(&self, x: f64) -> (String, Binding) {
        if !x.is_finite() {
            return ((self.syntax.not_finite)(x).to_owned(), Binding::Sum);
        }
        (format!("{x:?}"), if x.is_sign_negative() { Binding::Sign } else { Binding::Whole })
    }

    /// Its name. The library's own effects call functions only of parameters, which are numbers by then.
    fn function(&self, address: usize) -> &'static str {
        self.functions.get(&address).copied().unwrap_or_else(|| unreachable!("a function without a name"))
    }
}

/// Steps that the latest voltages reach back, where any are needed.
pub(super) fn reach(tape: &Tape, outputs: &[Recorded]) -> Option<usize> {
    let mut used = vec![false; tape.len()];
    outputs.iter().for_each(|output| used[output.0] = true);
    for place in (0..tape.len()).rev() {
        if used[place] {
            tape.node(place).arguments().for_each(|argument| used[argument] = true);
        }
    }
    (0..tape.len())
        .filter(|place| used[*place])
        .filter_map(|place| match tape.node(place) {
            Node::Back(steps) => match tape.node(steps) {
                Node::Constant(bits) => Some(f64::from_bits(bits).max(0.0) as usize + 1),
                _ => None,
            },
            _ => None,
        })
        .max()
}
