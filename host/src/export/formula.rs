//! A user's formula as an expression of another language.

use motorlens_shared::effects::{Definition, Entry, Operation, Quantity, Rig};

use super::laws::{Statements, number};

/// What a quantity is called.
pub(super) type Names<'a> = &'a dyn Fn(Quantity) -> String;

/// The program of `definition` with parameters `p` as an infix expression; C, Python and Modelica differ in `names`
/// and in what `call` makes of a function.
pub(super) fn expression(
    definition: &Definition,
    p: &[f64],
    names: Names,
    call: &dyn Fn(&str, &[String]) -> String,
) -> String {
    let mut stack: Vec<String> = Vec::new();
    for operation in definition.program() {
        let arguments = stack.split_off(stack.len() - operation.takes());
        let between = |sign: &str| format!("({} {sign} {})", arguments[0], arguments[1]);
        stack.push(match operation {
            Operation::Number(x) => number(*x),
            Operation::Read(quantity) => names(*quantity),
            Operation::Parameter(k) => number(p[*k]),
            Operation::Add => between("+"),
            Operation::Subtract => between("-"),
            Operation::Multiply => between("*"),
            Operation::Divide => between("/"),
            Operation::Negate => format!("(-{})", arguments[0]),
            Operation::Minimum => call("fmin", &arguments),
            Operation::Maximum => call("fmax", &arguments),
            Operation::Absolute => call("fabs", &arguments),
            Operation::Sign => call("sign", &arguments),
            Operation::Sine => call("sin", &arguments),
            Operation::Cosine => call("cos", &arguments),
            Operation::Function(name, _) | Operation::FunctionOfTwo(name, _) => call(name, &arguments),
        });
    }
    stack.pop().unwrap_or_default()
}

/// A call as C and Python write it.
fn called(name: &str, arguments: &[String]) -> String {
    format!("{name}({})", arguments.join(", "))
}

/// The statements of a formula in C and Python.
pub(super) fn statements(definition: &Definition, p: &[f64], rig: &Rig) -> Statements {
    let sensor = definition.entry() == Entry::Sensor;
    let after = if sensor { "2" } else { "" };
    let names = |quantity: Quantity| match quantity {
        Quantity::Voltage => "v".to_owned(),
        Quantity::Command => "volts".to_owned(),
        Quantity::Time => "time".to_owned(),
        Quantity::Current => format!("current{after}"),
        Quantity::Speed => format!("load_speed{after}"),
        Quantity::Angle => format!("load_angle{after}"),
        Quantity::MotorSpeed => format!("({:e} * speed{after})", rig.gear_ratio),
        Quantity::MotorAngle => format!("({:e} * angle{after})", rig.gear_ratio),
    };
    let value = expression(definition, p, &names, &called);
    let size = format!("fmax({value}, 0.0)");
    let drive = match definition.entry() {
        Entry::Torque => vec![format!("load_torque += {value}")],
        Entry::Voltage => vec![format!("v += {value}")],
        Entry::Drop => vec![format!("drop += {size}")],
        Entry::Resistance => vec![format!("series += {size}")],
        Entry::Friction => vec![format!("up += {size}"), format!("down += {size}")],
        Entry::Sensor => {
            return Statements { read: vec![format!("reading += {value}")], ..Statements::default() };
        }
    };
    Statements { drive, ..Statements::default() }
}
