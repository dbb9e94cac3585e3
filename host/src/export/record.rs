//! A number that writes down what is computed with it.
//!
//! The model runs once on [`Recorded`] numbers, as it does on `f64`, and leaves the expressions of every output. So an
//! exported program holds the very equations of `motorlens_shared`: there is no second copy of them to keep true.
//! Operations on constants are carried out as `f64` does them, equal expressions are one, and each choice is written as a
//! conditional expression, which is how the model makes it anyway.

use std::cell::RefCell;
use std::collections::HashMap;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use motorlens_shared::scalar::Scalar;

/// A function of one number, as [`Scalar::map`] takes it.
pub(super) type One = fn(f64) -> f64;
/// A function of two.
pub(super) type Two = fn(f64, f64) -> f64;

/// What is known only when the program runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Input {
    /// Voltage at the driver's output in this step, V.
    Command,
    /// The step's number, from 1.
    Step,
    /// Current as a voltage, V.
    Current,
    /// Speed of the rotor, seen through the gear, rad/s.
    Speed,
    /// Its angle, rad.
    Angle,
    /// Speed of the load, rad/s.
    LoadSpeed,
    /// Angle of the load, rad.
    LoadAngle,
    /// Angle of the load at the start, rad.
    Origin,
    /// Current, speeds and angles at the beginning of a step that has ended.
    WasCurrent,
    WasSpeed,
    WasAngle,
    WasLoadSpeed,
    WasLoadAngle,
    /// What the bridge was told in that step, V.
    Asked,
    /// What the effect of this number remembers.
    Store(usize),
    /// How long ago something happened to it, s.
    Age(usize),
}

/// An expression; numbers are places on the tape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Node {
    /// A constant, by its bits.
    Constant(u64),
    Input(Input),
    Add(usize, usize),
    Subtract(usize, usize),
    Multiply(usize, usize),
    Divide(usize, usize),
    Negate(usize),
    Absolute(usize),
    /// The first where it is less than the second, else the second.
    Least(usize, usize),
    /// The first where it is more than the second, else the second.
    Most(usize, usize),
    /// The third where the first is more than the second, else the fourth.
    Pick(usize, usize, usize, usize),
    /// The nearest integer.
    Round(usize),
    /// The voltage so many steps back, between two of them in proportion.
    Back(usize),
    /// A function of a user's formula, by its address.
    Call(usize, usize),
    /// The same of two numbers.
    CallOfTwo(usize, usize, usize),
}

impl Node {
    /// What it is computed from.
    pub(super) fn arguments(self) -> impl Iterator<Item = usize> {
        let arguments = match self {
            Self::Constant(_) | Self::Input(_) => [None; 4],
            Self::Negate(a) | Self::Absolute(a) | Self::Round(a) | Self::Back(a) | Self::Call(_, a) => {
                [Some(a), None, None, None]
            }
            Self::Add(a, b)
            | Self::Subtract(a, b)
            | Self::Multiply(a, b)
            | Self::Divide(a, b)
            | Self::Least(a, b)
            | Self::Most(a, b)
            | Self::CallOfTwo(_, a, b) => [Some(a), Some(b), None, None],
            Self::Pick(a, b, c, d) => [Some(a), Some(b), Some(c), Some(d)],
        };
        arguments.into_iter().flatten()
    }
}

/// All expressions of a recording; arguments stand before what is computed from them.
#[derive(Debug, Default)]
pub(super) struct Tape {
    nodes: Vec<Node>,
    known: HashMap<Node, usize>,
}

impl Tape {
    pub(super) fn node(&self, place: usize) -> Node {
        self.nodes[place]
    }

    /// The number of expressions.
    pub(super) fn len(&self) -> usize {
        self.nodes.len()
    }

    fn place(&mut self, node: Node) -> usize {
        *self.known.entry(node).or_insert_with(|| {
            self.nodes.push(node);
            self.nodes.len() - 1
        })
    }

    /// The value of a constant.
    fn constant(&self, place: usize) -> Option<f64> {
        match self.nodes[place] {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// Writes `node` down, or what is the same and simpler. Only what holds for every finite number is simplified.
    fn write(&mut self, node: Node) -> usize {
        if let Some(value) = self.computed(node) {
            return self.place(Node::Constant(value.to_bits()));
        }
        let is = |place: usize, value: f64| self.constant(place) == Some(value);
        match node {
            Node::Add(a, b) if is(a, 0.0) => b,
            Node::Add(a, b) | Node::Subtract(a, b) if is(b, 0.0) => a,
            Node::Subtract(a, b) if is(a, 0.0) => self.write(Node::Negate(b)),
            Node::Multiply(a, b) if is(a, 1.0) || is(b, 0.0) => b,
            Node::Multiply(a, b) if is(b, 1.0) || is(a, 0.0) => a,
            Node::Divide(a, b) if is(b, 1.0) || is(a, 0.0) => a,
            Node::Pick(_, _, x, y) if x == y => x,
            Node::Least(a, b) | Node::Most(a, b) if a == b => a,
            Node::Negate(a) => match self.nodes[a] {
                Node::Negate(inner) => inner,
                _ => self.place(node),
            },
            _ => self.place(node),
        }
    }

    /// The value of an expression of constants, as `f64` computes it.
    fn computed(&self, node: Node) -> Option<f64> {
        let of = |place: usize| self.constant(place);
        Some(match node {
            Node::Add(a, b) => of(a)? + of(b)?,
            Node::Subtract(a, b) => of(a)? - of(b)?,
            Node::Multiply(a, b) => of(a)? * of(b)?,
            Node::Divide(a, b) => of(a)? / of(b)?,
            Node::Negate(a) => -of(a)?,
            Node::Absolute(a) => of(a)?.abs(),
            Node::Least(a, b) => Scalar::min(of(a)?, of(b)?),
            Node::Most(a, b) => Scalar::max(of(a)?, of(b)?),
            Node::Round(a) => Scalar::round(of(a)?),
            // Known sides of a choice, and known arguments of a function, never get here.
            _ => return None,
        })
    }
}

thread_local! {
    /// The tape of the recording that runs on this thread; [`record`] takes it away with its result.
    static TAPE: RefCell<Tape> = RefCell::default();
}

/// Runs `work` and returns what it computed with all expressions it wrote.
pub(super) fn record<R>(work: impl FnOnce() -> R) -> (R, Tape) {
    TAPE.with(|tape| *tape.borrow_mut() = Tape::default());
    let result = work();
    (result, TAPE.with(RefCell::take))
}

/// A number of a recording: its place on the tape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Recorded(pub usize);

impl Recorded {
    fn new(node: Node) -> Self {
        Self(TAPE.with(|tape| tape.borrow_mut().write(node)))
    }
    /// What is known only when the program runs.
    pub(super) fn input(input: Input) -> Self {
        Self::new(Node::Input(input))
    }
    fn constant(self) -> Option<f64> {
        TAPE.with(|tape| tape.borrow().constant(self.0))
    }
}

macro_rules! writes {
    ($trait:ident, $method:ident, $node:ident) => {
        impl $trait for Recorded {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                Self::new(Node::$node(self.0, other.0))
            }
        }
    };
}
writes!(Add, add, Add);
writes!(Sub, sub, Subtract);
writes!(Mul, mul, Multiply);
writes!(Div, div, Divide);

impl Neg for Recorded {
    type Output = Self;
    fn neg(self) -> Self {
        Self::new(Node::Negate(self.0))
    }
}
impl AddAssign for Recorded {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
impl SubAssign for Recorded {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Scalar for Recorded {
    type Element = Self;
    fn lit(x: f64) -> Self {
        Self(TAPE.with(|tape| tape.borrow_mut().place(Node::Constant(x.to_bits()))))
    }
    fn splat(x: Self) -> Self {
        x
    }
    /// As `f64` does it: not fused.
    fn mul_add(self, m: Self, a: Self) -> Self {
        self * m + a
    }
    fn abs(self) -> Self {
        Self::new(Node::Absolute(self.0))
    }
    fn min(self, other: Self) -> Self {
        Self::new(Node::Least(self.0, other.0))
    }
    fn max(self, other: Self) -> Self {
        Self::new(Node::Most(self.0, other.0))
    }
    fn pick_gt(a: Self, b: Self, x: Self, y: Self) -> Self {
        if let (Some(left), Some(right)) = (a.constant(), b.constant()) {
            return if left > right { x } else { y };
        }
        Self::new(Node::Pick(a.0, b.0, x.0, y.0))
    }
    /// The model skips only what changes nothing; a recording skips nothing that may be needed.
    fn any_gt(a: Self, b: Self) -> bool {
        match (a.constant(), b.constant()) {
            (Some(a), Some(b)) => a > b,
            _ => true,
        }
    }
    fn round(self) -> Self {
        Self::new(Node::Round(self.0))
    }
    /// There is one table: the voltages up to this step.
    fn look_back(_table: &[Self], _index: usize, back: Self) -> Self {
        Self::new(Node::Back(back.0))
    }
    fn map(self, f: One) -> Self {
        match self.constant() {
            Some(x) => Self::lit(f(x)),
            None => Self::new(Node::Call(f as usize, self.0)),
        }
    }
    fn map_with(self, other: Self, f: Two) -> Self {
        match (self.constant(), other.constant()) {
            (Some(x), Some(y)) => Self::lit(f(x, y)),
            _ => Self::new(Node::CallOfTwo(f as usize, self.0, other.0)),
        }
    }
    fn count(_index: usize) -> Self {
        Self::input(Input::Step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_computed_and_equal_expressions_are_one() {
        let ([a, b, c], tape) = record(|| {
            let x = Recorded::input(Input::Speed);
            let k = Recorded::lit(2.0) * Recorded::lit(0.25);
            [x * k, x * Recorded::lit(0.5), (x + Recorded::zero()) * k]
        });
        assert!(a == b && b == c);
        assert!(matches!(tape.node(a.0), Node::Multiply(_, k) if tape.constant(k) == Some(0.5)));
    }

    #[test]
    fn a_choice_between_known_sides_is_made_and_any_other_is_written() {
        let ([known, open], tape) = record(|| {
            let x = Recorded::input(Input::Speed);
            let (one, two) = (Recorded::one(), Recorded::lit(2.0));
            [Recorded::pick_gt(two, one, x, -x), Recorded::pick_gt(x, one, x, one)]
        });
        assert!(matches!(tape.node(known.0), Node::Input(Input::Speed)));
        assert!(matches!(tape.node(open.0), Node::Pick(..)));
    }
}
