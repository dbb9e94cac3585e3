//! The run in words and tables.

use std::fmt::{Display, Formatter, Result};

use motorlens_shared::motor::Combinations;

use super::tables::PRINTED;
use super::{FitOn, PaperRun};

impl Display for PaperRun {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        self.source(f)?;
        self.figure_5(f)?;
        self.write_table_1(f)?;
        self.write_table_2(f)?;
        self.unsaid(f)?;
        self.with_the_effect(f)?;
        writeln!(f, "\nWhat the paper leaves open, and what was taken")?;
        for choice in &self.choices {
            writeln!(f, "  {}:\n      {}", choice.question, choice.taken)?;
        }
        for file in &self.files {
            writeln!(f, "wrote {}", file.display())?;
        }
        Ok(())
    }
}

impl PaperRun {
    fn source(&self, f: &mut Formatter<'_>) -> Result {
        let fitted = match self.fit_on {
            FitOn::Smallest => "the record of the smallest voltage is fitted",
            FitOn::All => "all records are fitted",
        };
        match self.hidden {
            Some(_) => writeln!(f, "Virtual geared motor, Kg = 104, with a hidden effect; {fitted}."),
            None => writeln!(f, "Your own logs; {fitted}."),
        }
    }

    fn figure_5(&self, f: &mut Formatter<'_>) -> Result {
        let ga = &self.ga;
        writeln!(f, "\nFigure 5: best objective (IAE) per generation")?;
        let last = ga.history.len();
        for generation in [1, 2, 5, 10, 20, 50, 100, 200, 400, 800] {
            if let Some(iae) = ga.history.get(generation - 1) {
                writeln!(f, "  {generation:>6}  {iae:.6}")?;
            }
        }
        writeln!(
            f,
            "  {last} generations, {} evaluations, {:.3} s on {}",
            ga.evaluations,
            ga.seconds,
            ga.level.name()
        )?;
        writeln!(
            f,
            "  the literal start made {} genes of {} negative or too small; they were clamped ({} more later)",
            ga.clamped,
            8 * self.population,
            ga.clamped_later
        )?;
        writeln!(
            f,
            "  IAE: GA {:.6}, conventional {:.6} ({} evaluations, ended by {}), fast search {:.6} ({} evaluations, {:.4} s)",
            ga.iae,
            self.conventional.iae,
            self.conventional.evaluations,
            self.conventional.ending,
            self.fast.iae,
            self.fast.evaluations,
            self.fast.seconds
        )
    }

    fn write_table_1(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "\nTable 1: parameters")?;
        writeln!(
            f,
            "  {:<4} {:<10} {:>12} {:>12} {:>12} {:>12}",
            "", "", "name plate", "conventional", "GA", "paper prints"
        )?;
        for p in &self.table_1 {
            writeln!(
                f,
                "  {:<4} {:<10} {:>12.4e} {:>12.4e} {:>12.4e} {:>12.4e}",
                p.symbol, p.unit, p.nameplate, p.conventional, p.ga, p.printed
            )?;
        }
        Ok(())
    }

    fn write_table_2(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "\nTable 2: average (AE) and largest (ME) error")?;
        writeln!(
            f,
            "  {:<24} {:>9} {:>9} {:>9} {:>9} {:>7}   {:>11}",
            "record", "GA AE", "GA ME", "conv. AE", "conv. ME", "ratio", "printed T1"
        )?;
        for row in &self.table_2 {
            writeln!(
                f,
                "  {:<24} {:>9.4} {:>9.4} {:>9.4} {:>9.4} {:>7.2}   {:>11.4}",
                row.record,
                row.ga.ae,
                row.ga.me,
                row.conventional.ae,
                row.conventional.me,
                row.ratio,
                row.printed_table_1.ae
            )?;
        }
        writeln!(
            f,
            "  as the paper prints it (its ratios, \"48, 8 and 5\", are these from its own figures):"
        )?;
        for (volts, ga, ga_most, conventional, most) in PRINTED {
            let name = format!("{volts} sin(0.5 pi t)");
            let ratio = conventional / ga;
            writeln!(
                f,
                "  {name:<24} {ga:>9.4} {ga_most:>9.4} {conventional:>9.4} {most:>9.4} {ratio:>7.2}"
            )?;
        }
        Ok(())
    }

    fn unsaid(&self, f: &mut Formatter<'_>) -> Result {
        writeln!(f, "\nWhat the paper does not say")?;
        writeln!(f, "  Voltage and motion determine three numbers, not eight:")?;
        combinations(f, "conventional", &self.conventional.combinations)?;
        combinations(f, "GA", &self.ga.combinations)?;
        combinations(f, "printed Table 1", &self.printed_combinations)?;
        if self.printed_combinations.time_constants().is_none() {
            writeln!(
                f,
                "  The printed Table 1 rings: no mechanical and electrical time constant give its poles."
            )?;
        }
        if let Some(growth) = self.growth {
            let paper = PRINTED[2].1 / PRINTED[0].1;
            writeln!(
                f,
                "  From the smallest to the largest voltage ({:.2} times) the GA's average error grows {:.1} times \
                 (in the paper {paper:.1} times).\n  A linear model that is merely mis-tuned would grow {:.2} times: \
                 {}.",
                growth.voltage,
                growth.error,
                growth.voltage,
                if growth.error > 1.5 * growth.voltage {
                    "a physical effect is missing"
                } else {
                    "no missing effect shows here"
                }
            )?;
        }
        if self.hidden.is_some() {
            writeln!(
                f,
                "  Sines of one frequency are one experiment: they tell a linear model nothing new."
            )?;
        }
        Ok(())
    }

    fn with_the_effect(&self, f: &mut Formatter<'_>) -> Result {
        let missing = &self.missing;
        let names = |kinds: &[motorlens_shared::effects::Kind]| {
            kinds.iter().map(ToString::to_string).collect::<Vec<_>>().join(" ")
        };
        if missing.effects.is_empty() {
            return writeln!(f, "\nThe missing effect: nothing worth adding was found.");
        }
        writeln!(f, "\nThe missing effect: {}", names(&missing.effects))?;
        for rivals in &missing.rivals {
            writeln!(f, "  these records cannot tell apart: {}", names(rivals))?;
        }
        if let Some(hidden) = self.hidden {
            writeln!(f, "  hidden in the virtual motor was: {hidden}")?;
        }
        for effect in &missing.model.effects {
            for p in &effect.parameters {
                writeln!(f, "  {} {} = {:.4} {}", effect.effect, p.name, p.value, p.unit)?;
            }
        }
        writeln!(f, "\nTable 2 with it")?;
        writeln!(f, "  {:<24} {:>9} {:>9} {:>12}", "record", "AE", "ME", "GA AE / AE")?;
        for (row, new) in self.table_2.iter().zip(&missing.table_2) {
            let unseen = if missing.unseen.contains(&row.record) { "  not seen by the fit" } else { "" };
            let ratio = row.ga.ae / new.ae;
            writeln!(f, "  {:<24} {:>9.4} {:>9.4} {ratio:>12.1}{unseen}", row.record, new.ae, new.me)?;
        }
        Ok(())
    }
}

fn combinations(f: &mut Formatter<'_>, name: &str, c: &Combinations) -> Result {
    writeln!(
        f,
        "    {name:<16} b/a1 {:>11.4e}  a2/a1 {:>11.4e}  a3/a1 {:>11.4e}   {:.4} rad/s per V",
        c.b_over_a1,
        c.a2_over_a1,
        c.a3_over_a1,
        c.gain()
    )
}
