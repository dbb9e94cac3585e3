//! From the text of a formula to a program, by winnow's expression parser.
//!
//! Numbers, names, `+ - * / ^`, parentheses and calls. As in every textbook `-x^2` is `-(x^2)` and `x^y^z` is
//! `x^(y^z)`.

use crate::nearest::nearest;
use motorlens_shared::effects::{Operation, Quantity};
use winnow::Parser;
use winnow::ascii::{float, multispace0};
use winnow::combinator::{
    Infix, Prefix, alt, dispatch, expression, fail, peek, preceded, separated, terminated,
};
use winnow::error::ParserError;
use winnow::token::{any, one_of, take_while};

/// What a formula may read, by name.
pub const QUANTITIES: [(&str, Quantity); 8] = [
    ("voltage", Quantity::Voltage),
    ("command", Quantity::Command),
    ("current", Quantity::Current),
    ("speed", Quantity::Speed),
    ("angle", Quantity::Angle),
    ("motor_speed", Quantity::MotorSpeed),
    ("motor_angle", Quantity::MotorAngle),
    ("time", Quantity::Time),
];

/// What a formula may call. C and Python know the functions by the names in here.
pub const FUNCTIONS: [(&str, Operation); 18] = [
    ("abs", Operation::Absolute),
    ("sign", Operation::Sign),
    ("min", Operation::Minimum),
    ("max", Operation::Maximum),
    ("sin", Operation::Sine),
    ("cos", Operation::Cosine),
    ("tan", Operation::Function("tan", f64::tan)),
    ("asin", Operation::Function("asin", f64::asin)),
    ("acos", Operation::Function("acos", f64::acos)),
    ("atan", Operation::Function("atan", f64::atan)),
    ("tanh", Operation::Function("tanh", f64::tanh)),
    ("exp", Operation::Function("exp", f64::exp)),
    ("ln", Operation::Function("log", f64::ln)),
    ("log", Operation::Function("log", f64::ln)),
    ("sqrt", Operation::Function("sqrt", f64::sqrt)),
    ("floor", Operation::Function("floor", f64::floor)),
    ("atan2", Operation::FunctionOfTwo("atan2", f64::atan2)),
    ("pow", POWER),
];

const POWER: Operation = Operation::FunctionOfTwo("pow", f64::powf);
/// Longer formulas are no equations of physics, and nesting must end somewhere.
const LONGEST: usize = 400;

/// Where a formula cannot be understood, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Byte of the text, counted from 0.
    pub at: usize,
    /// The cause, as a clause.
    pub why: String,
    /// What to do.
    pub remedy: String,
}

/// A fault while parsing: bytes left when it happened, and a cause where one is known.
#[derive(Debug)]
struct Stop {
    left: usize,
    cause: Option<(String, String)>,
    /// No other rule can fit: what came before has settled it.
    settled: bool,
}

impl Stop {
    fn settled(self) -> Self {
        Self { settled: true, ..self }
    }
}

impl ParserError<&str> for Stop {
    type Inner = Self;
    fn from_input(input: &&str) -> Self {
        Self { left: input.len(), cause: None, settled: false }
    }
    /// The rule that came further knows more.
    fn or(self, other: Self) -> Self {
        if self.left < other.left { self } else { other }
    }
    fn is_backtrack(&self) -> bool {
        !self.settled
    }
    fn into_inner(self) -> Result<Self, Self> {
        Ok(self)
    }
}

type Program = Vec<Operation>;

/// The program of `text`, whose own parameters are called `parameters`.
pub fn parse(text: &str, parameters: &[&str]) -> Result<Program, Fault> {
    if text.len() > LONGEST {
        let why = format!("the formula has {} characters, more than {LONGEST}", text.len());
        return Err(Fault { at: LONGEST, why, remedy: "write it as several effects".into() });
    }
    let mut input = text;
    let whole = sum(&mut input, parameters).and_then(|program| {
        multispace0.parse_next(&mut input)?;
        if input.is_empty() { Ok(program) } else { Err(Stop::from_input(&input)) }
    });
    whole.map_err(|stop| {
        let at = text.len() - stop.left;
        let (why, remedy) = stop.cause.unwrap_or_else(|| unexpected(&text[at..]));
        Fault { at, why, remedy }
    })
}

fn unexpected(rest: &str) -> (String, String) {
    let remedy = "write numbers, names, + - * / ^, parentheses and functions such as abs(speed)".to_owned();
    match rest.trim_start().chars().next() {
        None => ("the formula ends too early".into(), remedy),
        Some(c) => (format!("\"{c}\" cannot stand here"), remedy),
    }
}

fn sum(input: &mut &str, parameters: &[&str]) -> Result<Program, Stop> {
    let operand = |i: &mut &str| preceded(multispace0, |i: &mut &str| operand(i, parameters)).parse_next(i);
    expression(operand)
        .prefix(preceded(
            multispace0,
            dispatch! {any;
                '-' => Prefix(8, |_: &mut &str, a| Ok(then(a, vec![], Operation::Negate))),
                '+' => Prefix(8, |_: &mut &str, a| Ok(a)),
                _ => fail,
            },
        ))
        .infix(preceded(
            multispace0,
            dispatch! {any;
                '+' => Infix::Left(4, |_: &mut &str, a, b| Ok(then(a, b, Operation::Add))),
                '-' => Infix::Left(4, |_: &mut &str, a, b| Ok(then(a, b, Operation::Subtract))),
                '*' => Infix::Left(6, |_: &mut &str, a, b| Ok(then(a, b, Operation::Multiply))),
                '/' => Infix::Left(6, |_: &mut &str, a, b| Ok(then(a, b, Operation::Divide))),
                '^' => Infix::Right(10, |_: &mut &str, a, b| Ok(then(a, b, POWER))),
                _ => fail,
            },
        ))
        .parse_next(input)
}

fn then(mut a: Program, b: Program, operation: Operation) -> Program {
    a.extend(b);
    a.push(operation);
    a
}

fn operand(input: &mut &str, parameters: &[&str]) -> Result<Program, Stop> {
    let inner = |i: &mut &str| sum(i, parameters);
    let digit = peek(one_of(|c: char| c.is_ascii_digit() || c == '.'));
    let number = preceded(digit, float).map(|x: f64| vec![Operation::Number(x)]);
    let rest = terminated(inner, (multispace0, ')'));
    let group = preceded('(', rest.map_err(Stop::settled));
    alt((number, group, |i: &mut &str| named(i, parameters))).parse_next(input)
}

/// A parameter, a quantity, a constant, or a call.
fn named(input: &mut &str, parameters: &[&str]) -> Result<Program, Stop> {
    let left = input.len();
    peek(one_of(|c: char| c.is_alphabetic() || c == '_')).parse_next(input)?;
    let name: &str = take_while(1.., |c: char| c.is_alphanumeric() || c == '_').parse_next(input)?;
    let stop = |why: String, remedy: String| Stop { left, cause: Some((why, remedy)), settled: true };
    if input.trim_start().starts_with('(') {
        let Some((_, function)) = FUNCTIONS.iter().find(|(known, _)| *known == name) else {
            return Err(stop(format!("no function is called {name}"), meant(name, &functions())));
        };
        let inner = |i: &mut &str| sum(i, parameters);
        let comma = (multispace0::<&str, Stop>, ',');
        let inside = terminated(separated(1.., inner, comma), (multispace0, ')'));
        let arguments: Vec<Program> =
            preceded((multispace0, '('), inside.map_err(Stop::settled)).parse_next(input)?;
        if arguments.len() != function.takes() {
            let why = format!("{name} takes {} values, not {}", function.takes(), arguments.len());
            return Err(stop(why, "give it that many, separated by commas".into()));
        }
        let mut program = arguments.concat();
        program.push(*function);
        return Ok(program);
    }
    if let Some(k) = parameters.iter().position(|p| *p == name) {
        return Ok(vec![Operation::Parameter(k)]);
    }
    if let Some((_, quantity)) = QUANTITIES.iter().find(|(known, _)| *known == name) {
        return Ok(vec![Operation::Read(*quantity)]);
    }
    if name == "pi" {
        return Ok(vec![Operation::Number(std::f64::consts::PI)]);
    }
    let known: Vec<&str> = parameters.iter().copied().chain(QUANTITIES.iter().map(|q| q.0)).collect();
    Err(stop(format!("{name} is neither a parameter of this effect nor a quantity"), meant(name, &known)))
}

fn functions() -> Vec<&'static str> {
    FUNCTIONS.iter().map(|f| f.0).collect()
}

fn meant(name: &str, known: &[&str]) -> String {
    match nearest(name, known.iter().copied()) {
        Some(known) => format!("did you mean {known}?"),
        None => format!("use one of: {}", known.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> f64 {
        let program = parse(text, &["x"]).unwrap_or_else(|fault| panic!("{text}: {fault:?}"));
        let grows = |o: &Operation| 1 - o.takes() as i32;
        assert_eq!(program.iter().map(grows).sum::<i32>(), 1, "{text}");
        let look = |quantity| panic!("{quantity:?} is not in these formulas");
        super::super::evaluate(&program, &[3.0], &look)
    }

    #[test]
    fn precedence_is_that_of_textbooks() {
        for (text, truth) in [
            ("1 + 2 * x", 7.0),
            ("-x^2", -9.0),
            ("(-x)^2", 9.0),
            ("2^-1", 0.5),
            ("2^x^2", 512.0),
            ("8 / 2 / 2", 2.0),
            ("1 - 2 - x", -4.0),
            ("-2 * -x", 6.0),
            ("max(min(x, 2), 1e0)", 2.0),
            ("max(1, min(x, 2) + 0.5) * 2", 5.0),
            (" sqrt( 4 ) + .5 ", 2.5),
            ("1.5e-1*x", 0.45),
            ("pow(x, 2) - pi + pi", 9.0),
        ] {
            assert!((value(text) - truth).abs() < 1e-12, "{text} is {}", value(text));
        }
    }

    #[test]
    fn faults_stand_where_they_are_and_say_what_would_be_right() {
        for (text, at, why, remedy) in [
            ("2 * sped", 4, "sped is neither", "did you mean speed?"),
            ("1 + abz(x)", 4, "no function is called abz", "did you mean abs?"),
            ("max(x)", 0, "max takes 2 values, not 1", "separated by commas"),
            ("(1 + x", 6, "ends too early", "parentheses"),
            ("1 + ", 3, "ends too early", "numbers"),
            ("x x", 2, "\"x\" cannot stand here", "numbers"),
            ("x $ 2", 2, "\"$\" cannot stand here", "+ - * / ^"),
            ("", 0, "ends too early", "numbers"),
        ] {
            let fault = parse(text, &["x"]).unwrap_err();
            assert!(fault.why.contains(why) && fault.remedy.contains(remedy), "{text}: {fault:?}");
            assert!(fault.at.abs_diff(at) <= 1, "{text}: {fault:?}");
        }
        assert!(parse(&"(".repeat(300), &[]).is_err());
        assert!(parse(&"1+".repeat(300), &[]).unwrap_err().why.contains("characters"));
    }
}
