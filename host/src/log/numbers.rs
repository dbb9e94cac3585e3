//! Numbers as people and programs write them: decimal commas, thousands, brackets, hexadecimal.

/// The numbers of a file, which are written alike: what one of them tells of the decimal sign is true of all.
#[derive(Debug, Clone, Default)]
pub(super) struct OfFile {
    sign: DecimalSign,
    columns: Vec<Whole>,
    /// What stands between thousands in all columns, where the first rows tell.
    thousands: Option<char>,
}

impl OfFile {
    /// Numbers whose thousands stand apart by this sign, where one is told.
    pub fn with_thousands(thousands: Option<char>) -> Self {
        Self { thousands, ..Self::default() }
    }

    /// The number in a field of this column.
    pub fn read(&mut self, column: usize, text: &str) -> Option<f64> {
        if !self.sign.allows(text) {
            return None;
        }
        if let Some(sign) = self.thousands.filter(|sign| is_thousands(text, *sign)) {
            return text.replace(sign, "").parse().ok();
        }
        self.columns.resize(self.columns.len().max(column + 1), Whole::default());
        self.columns[column].read(text)
    }
}

/// What stands between the thousands of a file: told by a column whose whole numbers go on beyond 999, and by no field that has it elsewhere.
#[derive(Debug, Default)]
pub(super) struct Thousands {
    written: OfFile,
    decimal: Vec<char>,
    /// Signs that numbers of nothing else have for a decimal one, and those that stand where thousands would.
    plain: Vec<char>,
    grouped: Vec<char>,
}

impl Thousands {
    /// Looks at the fields of a row.
    pub fn see<'t>(&mut self, row: impl Iterator<Item = &'t str>) {
        for (column, text) in row.enumerate() {
            self.written.read(column, text);
            let is_decimal = |sign: &char| text.contains(*sign) && !is_thousands(text, *sign);
            self.decimal.extend(['.', ','].into_iter().filter(is_decimal));
            let is_plain = |sign: &char| is_decimal(sign) && is_plain(text, *sign);
            self.plain.extend(['.', ','].into_iter().filter(is_plain));
            self.grouped.extend(['.', ','].into_iter().filter(|sign| is_thousands(text, *sign)));
        }
    }

    /// The sign, where the rows tell one.
    pub fn sign(&self) -> Option<char> {
        let told = self.written.columns.iter().find_map(|column| column.between);
        // A file has one decimal sign: where the other one stands, it stands between thousands.
        let beside = |[sign, other]: [char; 2]| {
            let is_one = self.grouped.contains(&sign) && self.plain.contains(&other);
            is_one.then_some(sign)
        };
        let told = told.or_else(|| [['.', ','], [',', '.']].into_iter().find_map(beside));
        told.filter(|sign| !self.decimal.contains(sign))
    }
}

/// Whether a text is digits with this sign between them, once.
fn is_plain(text: &str, sign: char) -> bool {
    let digits = |c: char| c.is_ascii_digit() || c == sign;
    text.trim_start_matches(['-', '+']).chars().all(digits) && text.matches(sign).count() == 1
}

/// The decimal sign of a file, from the first number on that has one beyond doubt: no number of the file has it between its thousands.
#[derive(Debug, Clone, Copy, Default)]
struct DecimalSign(Option<char>);

impl DecimalSign {
    /// Whether a field may be a number of this file; the numbers so far decide.
    fn allows(&mut self, text: &str) -> bool {
        let count = |sign: char| text.matches(sign).count();
        let Some(sign) = self.0 else {
            let is_decimal = |sign: &char| is_plain(text, *sign) && !is_grouped(text, &[*sign]);
            self.0 = ['.', ','].into_iter().find(is_decimal);
            return true;
        };
        let other = if sign == '.' { ',' } else { '.' };
        let is_last = text.rfind(sign) > text.rfind(other) || count(sign) == 0;
        count(sign) < 2 && is_last
    }
}

/// Whole numbers of one column, row by row: `990`, then `1.000` or `1,000`, where another row's would be a decimal sign.
#[derive(Debug, Clone, Copy)]
struct Whole {
    /// All so far were plain whole numbers.
    only: bool,
    last: Option<f64>,
    between: Option<char>,
}

impl Default for Whole {
    fn default() -> Self {
        Self { only: true, last: None, between: None }
    }
}

impl Whole {
    /// The number in `text`. Thousands are told from decimals by what came before: the numbers go on, or they jump to a thousandth.
    fn read(&mut self, text: &str) -> Option<f64> {
        if !self.only && self.between.is_none() {
            return number(text);
        }
        let grouped = |sign: char| {
            is_thousands(text, sign).then(|| text.replace(sign, "").parse::<f64>().ok()).flatten()
        };
        if let Some(value) = self.between.and_then(grouped) {
            self.last = Some(value);
            return Some(value);
        }
        let plain = number(text)?;
        let is_whole = text.bytes().all(|b| b.is_ascii_digit() || b == b'-' || b == b'+');
        if let (true, false, Some(last)) = (self.only, is_whole, self.last) {
            let goes_on = |value: f64| (value - last).abs() < (plain - last).abs();
            for sign in ['.', ','] {
                if let Some(value) = grouped(sign).filter(|value| goes_on(*value)) {
                    (self.between, self.last) = (Some(sign), Some(value));
                    return Some(value);
                }
            }
        }
        self.only &= is_whole;
        self.last = Some(plain);
        Some(plain)
    }
}

/// The number in a field; a comma within a field is a decimal one, since it separates nothing, and thousands may stand apart.
pub(super) fn number(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().or_else(|| {
        let decimal_comma = text.contains(',');
        let point = decimal_comma.then(|| text.replacen(',', ".", 1));
        let plain = point.as_deref().unwrap_or(text);
        let with_point = point.as_ref().and_then(|text| text.parse().ok());
        with_point
            .or_else(|| with_thousands(plain))
            .or_else(|| points_and_comma(text))
            .or_else(|| twice_grouped(text))
            .or_else(|| hex(text))
            .or_else(|| one_of(text))
            .or_else(|| in_brackets(text))
            .or_else(|| typeset(text))
    })
}

/// The only number of an array, `[0.5]` or `(0.5,)`, as messages of ROS with one joint are exported.
fn one_of(text: &str) -> Option<f64> {
    let inside = text.strip_prefix('[').and_then(|text| text.strip_suffix(']'));
    let inside = inside.or_else(|| text.strip_prefix('(')?.strip_suffix(",)"));
    inside?.trim().trim_end_matches(',').parse().ok()
}

/// `(3.25)`, as accountants and their spreadsheets write -3.25.
pub(super) fn in_brackets(text: &str) -> Option<f64> {
    let inside = text.strip_prefix('(')?.strip_suffix(')')?.trim();
    (inside.starts_with(|c: char| c.is_ascii_digit() || c == '.')).then(|| number(inside))?.map(|size| -size)
}

/// A minus as books have it (`\u{2212}0.5`), and Fortran's exponent (`1.5D-03`).
fn typeset(text: &str) -> Option<f64> {
    let plain = text.replace('\u{2212}', "-").replace(['D', 'd'], "e");
    (plain != text).then(|| plain.parse().ok()).flatten()
}

/// `1'234.5`, as Swiss spreadsheets and pocket calculators write it, and the same with a narrow blank.
fn with_thousands(text: &str) -> Option<f64> {
    const BETWEEN: [char; 4] = ['\'', '\u{2019}', '\u{A0}', '\u{202F}'];
    if !text.contains(BETWEEN) {
        return None;
    }
    let whole = text.split('.').next().unwrap_or_default();
    is_grouped(whole, &BETWEEN).then(|| text.replace(BETWEEN, "").parse().ok()).flatten()
}

/// `1.234,5` of a German spreadsheet and `1,234.5` of an English one: which of both is decimal is told where both are there.
fn points_and_comma(text: &str) -> Option<f64> {
    let (decimal, between) = if text.rfind(',')? > text.rfind('.')? { (',', '.') } else { ('.', ',') };
    let (whole, part) = text.rsplit_once(decimal)?;
    let plain = || format!("{}.{part}", whole.replace(between, "")).parse().ok();
    is_grouped(whole, &[between]).then(plain).flatten()
}

/// `1.234.567` or `1,234,567`: twice in a number no sign is a decimal one.
fn twice_grouped(text: &str) -> Option<f64> {
    let sign = ['.', ','].into_iter().find(|sign| text.matches(*sign).count() > 1)?;
    is_grouped(text, &[sign]).then(|| text.replace(sign, "").parse().ok()).flatten()
}

/// Whether the digits of a number are in threes by this sign: `1.000`, where `0.125` is a decimal fraction.
fn is_thousands(text: &str, sign: char) -> bool {
    let is_below_one = text.trim_start_matches(['-', '+']).starts_with('0');
    text.contains(sign) && !is_below_one && is_grouped(text, &[sign])
}

/// Whether a whole number has its digits in threes, but for the first.
fn is_grouped(whole: &str, between: &[char]) -> bool {
    let mut groups = whole.trim_start_matches(['-', '+']).split(between);
    let digits = |group: &str| group.bytes().all(|b| b.is_ascii_digit());
    let first = groups.next().is_some_and(|group| (1..=3).contains(&group.len()) && digits(group));
    first && groups.all(|group| group.len() == 3 && digits(group))
}

/// `0x1A3F`; all digits of 32 or 64 bits are those of a number with a sign.
fn hex(text: &str) -> Option<f64> {
    let digits = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"))?;
    // A sign that is no digit is none.
    let number =
        digits.bytes().all(|b| b.is_ascii_hexdigit()).then(|| u64::from_str_radix(digits, 16).ok())??;
    Some(match digits.len() {
        8 => f64::from(number as u32 as i32),
        16 => number as i64 as f64,
        _ => number as f64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_typeset_minus_and_fortrans_exponent_are_read() {
        assert_eq!(
            ["\u{2212}0.5", "1.5D-03", "-2.0d+01"].map(number),
            [Some(-0.5), Some(0.0015), Some(-20.0)]
        );
        assert_eq!(["d", "D1", "dead"].map(number), [None; 3]);
    }

    #[test]
    fn the_decimal_sign_of_a_file_stands_between_no_thousands() {
        let allows = |before: &[&str], text: &str| {
            let mut sign = DecimalSign::default();
            before.iter().for_each(|text| assert!(sign.allows(text)));
            sign.allows(text)
        };
        assert!(!allows(&["24.945", "0.837987"], "28.549.896") && !allows(&["0.5"], "1.234,5"));
        assert!(!allows(&["0,25"], "1,234,567"));
        // Nothing decides, or it is not against it.
        assert!(allows(&["999.990", "12"], "1.000.000") && allows(&["0.5"], "1,234.5"));
        assert!(allows(&["0,25"], "1.234.567") && allows(&["0.5"], "-3") && allows(&["0,5"], "1.234,5"));
    }

    #[test]
    fn thousands_of_one_column_are_those_of_all() {
        let told = |rows: &[[&'static str; 3]]| {
            let mut thousands = Thousands::default();
            rows.iter().for_each(|row| thousands.see(row.iter().copied()));
            thousands.sign()
        };
        let rows =
            [["980", "6.000", "-12"], ["990", "6.000", "5"], ["1.000", "-4.000", "8"], ["1.010", "0", "9"]];
        let sign = told(&rows);
        assert_eq!(sign, Some('.'));
        assert_eq!(OfFile::with_thousands(sign).read(1, "-4.000"), Some(-4000.0));
        assert_eq!(OfFile::with_thousands(sign).read(1, "1.234.567"), Some(1_234_567.0));
        // What begins with a zero is a fraction, whatever stands between thousands.
        assert_eq!(OfFile::with_thousands(sign).read(1, "0.125"), Some(0.125));
        assert_eq!(OfFile::with_thousands(Some(',')).read(1, "-0,125"), Some(-0.125));
        // A decimal sign anywhere, or nothing that goes on.
        let decimals = [["980", "0.125", "1"], ["990", "6.25", "1"], ["1.000", "7", "2"]];
        assert_eq!(told(&decimals), None);
        assert_eq!(told(&[["0", "6.000", "1"], ["1", "6.125", "2"]]), None);
        // The other sign is a decimal one, and no number has both for that.
        assert_eq!(told(&[["0.01", "5.5", "10,000"], ["0.02", "5.5", "10,125"]]), Some(','));
        assert_eq!(told(&[["0,01", "5,5", "10.000"], ["0,02", "5,5", "-10.125"]]), Some('.'));
        assert_eq!(told(&[["0.01", "5.5", "10,000"], ["0.02", "5.5", "0,125"]]), None);
        assert_eq!(told(&[["12:00:00.25", "5,125", "1"], ["12:00:00.26", "6,125", "2"]]), None);
        assert_eq!(OfFile::default().read(1, "-4.000"), Some(-4.0));
    }

    #[test]
    fn brackets_are_a_minus_and_an_array_of_one_is_its_number() {
        assert_eq!(["(3.25)", "(1,234.5)", "( 2 )"].map(number), [Some(-3.25), Some(-1234.5), Some(-2.0)]);
        assert_eq!(["[0.5]", "(0.5,)", "[-1]"].map(number), [Some(0.5), Some(0.5), Some(-1.0)]);
        assert_eq!(["(-3)", "(V)", "((3))", "()"].map(number), [None; 4]);
    }

    #[test]
    fn thousands_are_told_from_decimals_by_the_numbers_before() {
        let read = |texts: &[&str]| {
            let mut column = Whole::default();
            texts.iter().map(|text| column.read(text).unwrap_or(f64::NAN)).collect::<Vec<_>>()
        };
        assert_eq!(read(&["980", "990", "1.000", "1.010"]), [980.0, 990.0, 1000.0, 1010.0]);
        assert_eq!(read(&["-990", "-1,000", "-999"]), [-990.0, -1000.0, -999.0]);
        assert_eq!(read(&["999.990", "1.000.000"]), [999.99, 1e6]);
        // Decimals whose zeros were left out.
        assert_eq!(read(&["5", "5", "4.926", "5"]), [5.0, 5.0, 4.926, 5.0]);
        assert_eq!(read(&["0", "1", "1.125", "1.25"]), [0.0, 1.0, 1.125, 1.25]);
        assert_eq!(read(&["0", "0", "0.125"]), [0.0, 0.0, 0.125]);
        assert_eq!(read(&["-120", "-0.125", "-0,250"]), [-120.0, -0.125, -0.25]);
    }
}
