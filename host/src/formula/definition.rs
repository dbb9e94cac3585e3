//! From what is written of an effect to what the fit works with.

use motorlens_shared::effects::{
    Definition, Entry, Kind, Operation, Parameter, Port, Quantity, Scale, Search, Spec, Unsound,
};
use motorlens_shared::simulator::MAX_PARAMETERS;
use serde::{Deserialize, Serialize};

use super::grammar::{self, QUANTITIES};

/// An effect as its file and the model file have it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Written {
    /// Name that users type.
    pub name: String,
    /// What the value is.
    pub port: String,
    /// The value.
    pub formula: String,
    /// A line of plain words.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub title: String,
    /// What it looks like in data.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub signature: String,
    /// Where the equation is from.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
    /// Its parameters, in order.
    pub parameters: Vec<WrittenParameter>,
}

/// A parameter of it, in its own unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WrittenParameter {
    /// Name in the formula and in results.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// What it is.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub meaning: String,
    /// Lowest value.
    pub low: f64,
    /// A size one meets.
    pub typical: f64,
    /// Highest value.
    pub high: f64,
}

/// What of an effect is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Field {
    /// Its name.
    Name,
    /// Its port.
    Port,
    /// Its formula, from this byte on.
    Formula(usize),
    /// This parameter.
    Parameter(usize),
}

/// Why an effect cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Wrong {
    /// What of it.
    pub field: Field,
    /// The cause, as a clause.
    pub why: String,
    /// What to do.
    pub remedy: String,
}

/// Ports by name.
const PORTS: [(&str, Entry, Port); 6] = [
    ("torque", Entry::Torque, Port::Torque),
    ("friction", Entry::Friction, Port::Torque),
    ("voltage", Entry::Voltage, Port::Voltage),
    ("drop", Entry::Drop, Port::Voltage),
    ("resistance", Entry::Resistance, Port::Voltage),
    ("sensor", Entry::Sensor, Port::Sensor),
];

impl Written {
    /// Checks everything and makes the effect; it lives as long as the process.
    pub(super) fn define(&self) -> Result<&'static Definition, Wrong> {
        let wrong = |field, why: String, remedy: &str| Wrong { field, why, remedy: remedy.to_owned() };
        if !is_name(&self.name) {
            let why = format!("\"{}\" is no name of an effect", self.name);
            return Err(wrong(Field::Name, why, "use small letters, digits and _, a letter first"));
        }
        if self.name == "none" || Kind::by_name(&self.name).is_some() {
            let why = format!("the library has an effect called {} already", self.name);
            return Err(wrong(Field::Name, why, "take another name"));
        }
        let Some((_, entry, port)) = PORTS.iter().find(|(name, ..)| *name == self.port) else {
            let names: Vec<&str> = PORTS.iter().map(|p| p.0).collect();
            let why = format!("\"{}\" is no port", self.port);
            return Err(wrong(Field::Port, why, &format!("use one of: {}", names.join(", "))));
        };
        self.check_parameters()?;
        let names: Vec<&str> = self.parameters.iter().map(|p| p.name.as_str()).collect();
        let program = grammar::parse(&self.formula, &names).map_err(|f| Wrong {
            field: Field::Formula(f.at),
            why: f.why,
            remedy: f.remedy,
        })?;
        self.check_use(&program, *entry)?;
        let spec = self.spec(*port, *entry, &program);
        let definition = Definition::new(spec, *entry, leak(program)).map_err(|unsound| {
            let (why, remedy) = match unsound {
                Unsound::TooDeep => ("it is nested too deeply", "write it with fewer parentheses"),
                Unsound::Unknown => {
                    ("a sensor knows angle, speed and current only", "use port = \"voltage\" or \"torque\"")
                }
                Unsound::Unbalanced | Unsound::Parameters => ("it cannot be evaluated", "simplify it"),
            };
            wrong(Field::Formula(0), why.to_owned(), remedy)
        })?;
        Ok(Box::leak(Box::new(definition)))
    }

    fn check_parameters(&self) -> Result<(), Wrong> {
        let count = self.parameters.len();
        if !(1..=MAX_PARAMETERS).contains(&count) {
            let why = format!("an effect has 1 to {MAX_PARAMETERS} parameters, and this one {count}");
            let remedy =
                "write what is known as a number, what is to be fitted as a [[parameter]]".to_owned();
            return Err(Wrong { field: Field::Formula(0), why, remedy });
        }
        for (k, p) in self.parameters.iter().enumerate() {
            let wrong = |why: String, remedy: &str| {
                Err(Wrong { field: Field::Parameter(k), why, remedy: remedy.to_owned() })
            };
            let taken = QUANTITIES.iter().any(|q| q.0 == p.name)
                || p.name == "pi"
                || self.parameters[..k].iter().any(|other| other.name == p.name);
            if !is_name(&p.name) || taken {
                let why = format!("\"{}\" cannot be the name of a parameter", p.name);
                return wrong(
                    why,
                    "use small letters, digits and _, and no name that means something already",
                );
            }
            if !(p.low < p.high && p.low.is_finite() && p.high.is_finite()) {
                let why = format!("low = {} is not below high = {}", p.low, p.high);
                return wrong(why, "give both in the parameter's unit");
            }
            if !(p.low..=p.high).contains(&p.typical) || p.typical <= 0.0 {
                let why = format!("typical = {} is not a positive size between low and high", p.typical);
                return wrong(why, "give a size that one meets; it is the step of searches");
            }
        }
        Ok(())
    }

    /// What can be computed but is not meant.
    fn check_use(&self, program: &[Operation], entry: Entry) -> Result<(), Wrong> {
        let used = |k| program.iter().any(|o| matches!(o, Operation::Parameter(p) if *p == k));
        if let Some(k) = (0..self.parameters.len()).find(|k| !used(*k)) {
            let why = format!("the formula does not use the parameter {}", self.parameters[k].name);
            return Err(Wrong { field: Field::Parameter(k), why, remedy: "remove it".into() });
        }
        let friction = self.formula.replace(' ', "");
        let held = [("sign(speed)", Entry::Torque, "friction"), ("sign(current)", Entry::Voltage, "drop")];
        for (text, port, meant) in held {
            if let (true, Some(_)) = (entry == port, friction.find(text)) {
                let at = self.formula.find("sign").unwrap_or(0);
                let why = format!(
                    "{text} jumps where the motor rests, and a step that is held would chatter there"
                );
                let remedy = format!(
                    "use port = \"{meant}\" with the size alone, without the sign: it then holds exactly"
                );
                return Err(Wrong { field: Field::Formula(at), why, remedy });
            }
        }
        Ok(())
    }

    fn spec(&self, port: Port, entry: Entry, program: &[Operation]) -> Spec {
        let or = |text: &str, other: String| if text.is_empty() { other } else { text.to_owned() };
        let parameters: Vec<Parameter> = self
            .parameters
            .iter()
            .enumerate()
            .map(|(k, p)| Parameter {
                name: text(&p.name),
                unit: text(&p.unit),
                meaning: text(&p.meaning),
                scale: Scale::Own,
                low: p.low,
                high: p.high,
                typical: p.typical,
                most: None,
                searched: true,
                strength: k == 0,
            })
            .collect();
        Spec {
            name: text(&self.name),
            port,
            title: text(&or(&self.title, format!("{} = {}", self.port, self.formula))),
            equation: text(&format!("{} = {}", self.port, self.formula)),
            source: text(&or(&self.source, "the user's formula".into())),
            signature: text(&or(&self.signature, "what the formula says".into())),
            probes: leak(self.probes().into_iter().map(|p| leak(p) as &[f64]).collect()),
            parameters: leak(parameters),
            search: Search::Probes,
            laws: entry.laws(),
            remembers: false,
            periodic: is_periodic(program),
            by_duty: false,
            contains: &[],
        }
    }

    /// Trial values: sizes around the typical one, of both signs where the bounds allow it, for each of some shapes.
    fn probes(&self) -> Vec<Vec<f64>> {
        let mut probes: Vec<Vec<f64>> = vec![Vec::new()];
        for (k, p) in self.parameters.iter().enumerate() {
            let factors: &[f64] = if k == 0 { &[1.0, 0.25, 4.0] } else { &[1.0, 4.0, 0.25] };
            let signs: &[f64] = if p.low < 0.0 { &[1.0, -1.0] } else { &[1.0] };
            let mut sizes: Vec<f64> = factors
                .iter()
                .flat_map(|f| signs.iter().map(move |s| s * f * p.typical))
                .map(|x| x.clamp(p.low, p.high))
                .collect();
            sizes.dedup();
            // Every further parameter may only multiply as far as there is room.
            let room = (MOST_PROBES / probes.len()).max(1);
            sizes.truncate(room);
            probes = sizes
                .iter()
                .flat_map(|x| probes.iter().map(move |p| [p.as_slice(), &[*x]].concat()))
                .collect();
        }
        probes
    }
}

const MOST_PROBES: usize = 24;

/// Whether a `program` repeats with the turns of a shaft: it takes the sine, the cosine or the tangent of what depends on an angle.
fn is_periodic(program: &[Operation]) -> bool {
    // Of each number on the stack, whether it depends on an angle.
    let mut by_angle: Vec<bool> = Vec::new();
    program.iter().any(|operation| {
        let taken = by_angle.split_off(by_angle.len().saturating_sub(operation.takes()));
        let is_angle = matches!(operation, Operation::Read(Quantity::Angle | Quantity::MotorAngle));
        let depends = is_angle || taken.contains(&true);
        by_angle.push(depends);
        depends && matches!(operation, Operation::Sine | Operation::Cosine | Operation::Function("tan", _))
    })
}

fn is_name(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_lowercase())
        && text.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_')
}

fn text(text: &str) -> &'static str {
    Box::leak(text.to_owned().into_boxed_str())
}

fn leak<T>(list: Vec<T>) -> &'static [T] {
    Box::leak(list.into_boxed_slice())
}
