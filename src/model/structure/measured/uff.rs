//! Universal files: frequency responses (data set 58, text and binary) and modes (data set 55).

use super::response::{MeasuredDof, MeasuredFrf, Motion};
use crate::structure::error::{FileFault, StructureError};

/// Lines of a data set 58 before its values.
const HEAD_58: usize = 11;
/// Function type of a frequency response.
const RESPONSE: i64 = 4;
/// Most values of one response.
const MOST_POINTS: usize = 50_000_000;

/// Whether a file is a universal file: its first line is -1.
pub(in crate::structure) fn is_uff(bytes: &[u8]) -> bool {
    let head = &bytes[..bytes.len().min(200)];
    String::from_utf8_lossy(head).lines().map(str::trim).find(|line| !line.is_empty()) == Some("-1")
}

/// Place in a file.
struct Cursor<'a> {
    file: &'a str,
    bytes: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Cursor<'a> {
    /// The next line without its end; `None` at the end of the file.
    fn line(&mut self) -> Option<String> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let length = rest.iter().position(|byte| *byte == b'\n').map_or(rest.len(), |end| end + 1);
        self.at += length;
        self.line += 1;
        let text: String = rest[..length].iter().map(|byte| char::from(*byte)).collect();
        Some(text.trim_end_matches(['\n', '\r']).to_owned())
    }

    fn expect(&mut self, wanted: &str) -> Result<String, StructureError> {
        self.line().ok_or_else(|| self.fault(format!("the file is truncated: {wanted} expected")))
    }

    fn fault(&self, reason: impl Into<String>) -> StructureError {
        FileFault { file: self.file.to_owned(), line: self.line, reason: reason.into() }.into()
    }

    /// The line behind the -1 that begins a data set; some writers begin a file with two of them.
    fn head(&mut self) -> Option<String> {
        let mut head = self.line()?;
        while head.trim() == "-1" {
            head = self.line()?;
        }
        Some(head)
    }

    /// Moves behind the end of a data set.
    fn skip(&mut self) {
        while let Some(line) = self.line() {
            if line.trim() == "-1" {
                return;
            }
        }
    }

    /// Whole numbers of a line.
    fn integers(&self, text: &str) -> Vec<i64> {
        text.split_whitespace().map_while(|word| word.parse().ok()).collect()
    }
}

/// Length of a unit of the file in m, and its force in N (data set 164 has the reciprocals).
#[derive(Clone, Copy)]
struct Scale {
    metres: f64,
    newtons: f64,
}

/// Reads the frequency responses of translations per force.
pub(super) fn responses(file: &str, bytes: &[u8]) -> Result<Vec<MeasuredFrf>, StructureError> {
    let mut cursor = Cursor { file, bytes, at: 0, line: 0 };
    let mut scale = Scale { metres: 1.0, newtons: 1.0 };
    let mut out = Vec::new();
    while let Some(line) = cursor.line() {
        if line.trim() != "-1" {
            continue;
        }
        let Some(head) = cursor.head() else { break };
        let number = head.trim_start().split(|c: char| !c.is_ascii_digit()).next().unwrap_or_default().to_owned();
        match number.as_str() {
            "164" => scale = units(&mut cursor)?,
            "58" => out.extend(response(&mut cursor, &head, scale)?),
            _ => cursor.skip(),
        }
    }
    Ok(out)
}

/// Data set 164: factors by which SI values were multiplied.
fn units(cursor: &mut Cursor) -> Result<Scale, StructureError> {
    cursor.expect("the units of data set 164")?;
    let text = cursor.expect("the factors of data set 164")?;
    let factors = numbers(&text, &[25; 3]);
    let factors = factors.filter(|factors| factors.len() >= 2 && factors.iter().all(|factor| *factor > 0.0));
    let Some(factors) = factors else {
        return Err(cursor.fault(format!("expected factors of length and force, found \"{}\"", text.trim())));
    };
    cursor.skip();
    Ok(Scale { metres: factors[0].recip(), newtons: factors[1].recip() })
}

/// Storage of the values of a data set 58.
struct Layout {
    complex: bool,
    double: bool,
    even: bool,
    points: usize,
    first: f64,
    step: f64,
}

impl Layout {
    /// Values per point.
    fn width(&self) -> usize {
        usize::from(!self.even) + if self.complex { 2 } else { 1 }
    }

    /// Widths of the fields of a line.
    fn fields(&self) -> Vec<usize> {
        match (self.double, self.even, self.complex) {
            (false, ..) => vec![13; 6],
            (true, true, _) => vec![20; 4],
            (true, false, false) => vec![13, 20, 13, 20],
            (true, false, true) => vec![13, 20, 20],
        }
    }
}

/// A data set 58; `None` if it is not a frequency response.
fn response(cursor: &mut Cursor, head: &str, scale: Scale) -> Result<Option<MeasuredFrf>, StructureError> {
    let binary = head.trim_start().strip_prefix("58").filter(|rest| rest.starts_with(['b', 'B']));
    let binary = binary.map(|rest| cursor.integers(&rest[1..]));
    let mut lines = Vec::with_capacity(HEAD_58);
    for _ in 0..HEAD_58 {
        lines.push(cursor.expect("the head of a data set 58")?);
    }
    let (function, dofs) = function(cursor, &lines[5])?;
    let layout = layout(cursor, &lines[6])?;
    let kind = |line: &str| line.get(..10).unwrap_or(line).trim().parse::<i64>().unwrap_or(0);
    let (motion, force) = (kind(&lines[8]), kind(&lines[9]));
    let values = match binary {
        Some(head) => binary_values(cursor, &head, &layout)?,
        None => text_values(cursor, &layout)?,
    };
    if function != RESPONSE {
        return Ok(None);
    }
    let motion = match motion {
        8 => Motion::Displacement,
        11 => Motion::Velocity,
        12 => Motion::Acceleration,
        other => {
            return Err(cursor.fault(format!(
                "a frequency response of data type {other}: expected 8 (displacement), 11 (velocity) or 12 (acceleration) per force"
            )));
        }
    };
    if ![9, 13].contains(&force) || !layout.complex {
        let found = if layout.complex { format!("data type {force}") } else { "real values".to_owned() };
        return Err(
            cursor.fault(format!("expected complex values of a motion per force (data type 13 or 9), found {found}"))
        );
    }
    let [response, force] =
        dofs.ok_or_else(|| cursor.fault("expected translations as response and reference (directions 1 to 3)"))?;
    let mut frf = MeasuredFrf { response, force, frequency_hz: Vec::new(), mobility: Vec::new() };
    for (point, value) in values.chunks_exact(layout.width()).enumerate() {
        let (hz, value) = match layout.even {
            true => (layout.first + point as f64 * layout.step, [value[0], value[1]]),
            false => (value[0], [value[1], value[2]]),
        };
        if hz < 0.0 || frf.frequency_hz.last().is_some_and(|last| hz <= *last) || !hz.is_finite() {
            return Err(cursor.fault(format!("frequencies must rise from 0 on, found {hz} Hz as point {}", point + 1)));
        }
        // At 0 Hz there is no mobility.
        if hz > 0.0 {
            let value = value.map(|part| part * scale.metres / scale.newtons);
            frf.frequency_hz.push(hz);
            frf.mobility.push(motion.mobility(std::f64::consts::TAU * hz, value));
        }
    }
    Ok(Some(frf))
}

/// Function type, and response and reference where both are translations.
fn function(cursor: &Cursor, text: &str) -> Result<(i64, Option<[MeasuredDof; 2]>), StructureError> {
    // Format 2(I5,I10),2(1X,10A1,I10,I4).
    let field = |first: usize, width: usize| text.get(first..(first + width).min(text.len())).map(str::trim);
    let number = |first: usize, width: usize| field(first, width).and_then(|text| text.parse::<i64>().ok());
    let by_columns = [number(0, 5), number(41, 10), number(51, 4), number(66, 10), number(76, 4)];
    let by_words = || {
        let words: Vec<&str> = text.split_whitespace().collect();
        let at = |index: usize| words.get(index).and_then(|word| word.parse::<i64>().ok());
        if words.len() >= 10 { [at(0), at(5), at(6), at(8), at(9)] } else { [None; 5] }
    };
    let found = if by_columns.iter().all(Option::is_some) { by_columns } else { by_words() };
    let [Some(function), Some(response), Some(moved), Some(reference), Some(pushed)] = found else {
        return Err(cursor.fault(format!(
            "expected function type, response and reference node and direction, found \"{}\"",
            text.trim()
        )));
    };
    let dof = |node: i64, direction: i64| {
        let axis = usize::try_from(direction.abs()).ok().filter(|axis| (1..=3).contains(axis))? - 1;
        Some(MeasuredDof { place: node.to_string(), axis, reversed: direction < 0 })
    };
    let dofs = dof(response, moved).and_then(|response| Some([response, dof(reference, pushed)?]));
    Ok((function, dofs))
}

fn layout(cursor: &Cursor, text: &str) -> Result<Layout, StructureError> {
    let fault = || cursor.fault(format!("expected type, number and spacing of the values, found \"{}\"", text.trim()));
    let values = numbers(text, &[10, 10, 10, 13, 13, 13]).filter(|values| values.len() >= 5).ok_or_else(fault)?;
    let points = values[1];
    if !(points >= 0.0 && points <= MOST_POINTS as f64) {
        return Err(fault());
    }
    let kind = values[0];
    if ![2.0, 4.0, 5.0, 6.0].contains(&kind) {
        return Err(cursor.fault(format!("data type {kind}: expected 2, 4 (real), 5 or 6 (complex)")));
    }
    Ok(Layout {
        complex: kind >= 5.0,
        double: kind == 4.0 || kind == 6.0,
        even: values[2] == 1.0,
        points: points as usize,
        first: values[3],
        step: values[4],
    })
}

/// Values in the bytes behind the head. Writers state other numbers of bytes than they write, so the number of values counts.
fn binary_values(cursor: &mut Cursor, head: &[i64], layout: &Layout) -> Result<Vec<f64>, StructureError> {
    let [order, format] = [0, 1].map(|index| head.get(index).copied().unwrap_or(0));
    if ![1, 2].contains(&order) || format != 2 {
        let reason = format!("byte order {order}, floating point format {format}: expected 1 or 2, and 2 (IEEE 754)");
        return Err(cursor.fault(reason));
    }
    let size = if layout.double { 8 } else { 4 };
    let length = layout.points * layout.width() * size;
    let Some(bytes) = cursor.bytes.get(cursor.at..cursor.at + length) else {
        return Err(cursor.fault(format!("the file is truncated: {length} bytes of values expected")));
    };
    cursor.at += length;
    let value = |chunk: &[u8]| {
        let mut bytes = [0; 8];
        bytes[..size].copy_from_slice(chunk);
        if order == 2 {
            bytes[..size].reverse();
        }
        match layout.double {
            true => f64::from_le_bytes(bytes),
            false => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        }
    };
    let values: Vec<f64> = bytes.chunks_exact(size).map(value).collect();
    if values.iter().any(|value| !value.is_finite()) {
        return Err(cursor.fault("a value is not finite: is the byte order another one, or the file in text mode?"));
    }
    // Line ends after the values belong to none.
    let rest = &cursor.bytes[cursor.at..];
    let end = rest.iter().take(16).position(|byte| *byte == b'-').unwrap_or(0);
    if !String::from_utf8_lossy(&rest[..rest.len().min(end + 2)]).trim().starts_with("-1") {
        return Err(cursor.fault("the values do not end where their number says: was the file changed in text mode?"));
    }
    cursor.skip();
    Ok(values)
}

fn text_values(cursor: &mut Cursor, layout: &Layout) -> Result<Vec<f64>, StructureError> {
    let wanted = layout.points * layout.width();
    let fields = layout.fields();
    let mut values = Vec::new();
    loop {
        let text = cursor.expect("the end of a data set 58")?;
        if text.trim() == "-1" {
            break;
        }
        let found = numbers(&text, &fields)
            .ok_or_else(|| cursor.fault(format!("expected finite numbers, found \"{}\"", text.trim())))?;
        values.extend(found);
    }
    if values.len() != wanted {
        return Err(cursor.fault(format!(
            "expected {wanted} values of {} points, found {}",
            layout.points,
            values.len()
        )));
    }
    Ok(values)
}

/// Numbers in fields of these widths, or, where a line does not keep to them, one after the other: `1.5E+00-2.D-03`.
fn numbers(text: &str, widths: &[usize]) -> Option<Vec<f64>> {
    by_columns(text, widths).or_else(|| by_form(text))
}

fn by_columns(text: &str, widths: &[usize]) -> Option<Vec<f64>> {
    let text = text.trim_end();
    if !text.is_ascii() || text.contains('\t') {
        return None;
    }
    let mut out = Vec::new();
    let mut at = 0;
    for width in widths {
        if at >= text.len() {
            break;
        }
        let field = text[at..(at + width).min(text.len())].trim();
        // A field that is not filled up to its end belongs to a line in free form.
        if field.contains(' ') || (at + width > text.len() && !field.is_empty()) {
            return None;
        }
        out.push(number(field)?);
        at += width;
    }
    (at >= text.len()).then_some(out)
}

fn number(word: &str) -> Option<f64> {
    let value: f64 = word.replace(['D', 'd'], "E").parse().ok()?;
    value.is_finite().then_some(value)
}

/// Numbers by their form: a sign that follows no exponent letter begins a new one.
fn by_form(text: &str) -> Option<Vec<f64>> {
    let mut words: Vec<String> = Vec::new();
    let mut last = ' ';
    for character in text.chars() {
        let begins = (character == '-' || character == '+') && !matches!(last, 'E' | 'e' | 'D' | 'd');
        if last.is_whitespace() || begins {
            words.push(String::new());
        }
        if !character.is_whitespace() {
            words.last_mut()?.push(character);
        }
        last = character;
    }
    words.iter().filter(|word| !word.is_empty()).map(|word| number(word)).collect()
}

/// A normal mode of a data set 55.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::structure) struct UffMode {
    pub frequency_hz: f64,
    pub damping_ratio: f64,
    /// Node and values along x, y, z (and about them), scaled to a modal mass of 1 kg.
    pub shape: Vec<(i64, Vec<f64>)>,
}

/// Reads the normal modes of data sets 55.
pub(in crate::structure) fn modes(file: &str, bytes: &[u8]) -> Result<Vec<UffMode>, StructureError> {
    let mut cursor = Cursor { file, bytes, at: 0, line: 0 };
    let mut scale = Scale { metres: 1.0, newtons: 1.0 };
    let mut out = Vec::new();
    while let Some(line) = cursor.line() {
        if line.trim() != "-1" {
            continue;
        }
        let Some(head) = cursor.head() else { break };
        match head.trim() {
            "164" => scale = units(&mut cursor)?,
            "55" => out.extend(mode(&mut cursor, scale)?),
            _ => cursor.skip(),
        }
    }
    if out.is_empty() {
        let reason = "no normal modes found: expected data sets 55 of analysis type 2";
        return Err(StructureError::Matrix { file: file.to_owned(), reason: reason.to_owned() });
    }
    out.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    Ok(out)
}

fn mode(cursor: &mut Cursor, scale: Scale) -> Result<Option<UffMode>, StructureError> {
    for _ in 0..5 {
        cursor.expect("the head of a data set 55")?;
    }
    let text = cursor.expect("the kind of a data set 55")?;
    let kind = cursor.integers(&text);
    let [Some(analysis), Some(data), Some(count)] = [1, 4, 5].map(|index| kind.get(index).copied()) else {
        return Err(cursor.fault(format!("expected six whole numbers, found \"{}\"", text.trim())));
    };
    if analysis == 3 || (analysis == 2 && data != 2) {
        return Err(cursor
            .fault("a complex mode: expected normal modes (analysis type 2, real values); export them as real modes"));
    }
    if analysis != 2 {
        cursor.skip();
        return Ok(None);
    }
    cursor.expect("numbers of a data set 55")?;
    let text = cursor.expect("frequency, modal mass and damping")?;
    let facts = numbers(&text, &[13; 6])
        .filter(|facts| facts.len() >= 3 && facts[0] >= 0.0 && facts[1] > 0.0 && facts[2] >= 0.0);
    let Some(facts) = facts else {
        return Err(
            cursor.fault(format!("expected frequency, modal mass and damping ratio, found \"{}\"", text.trim()))
        );
    };
    let [frequency_hz, modal_mass, damping_ratio] = [facts[0], facts[1], facts[2]];
    // The unit of mass follows from length and force; shapes have the unit of length.
    let kilograms = modal_mass * scale.newtons / scale.metres;
    let mut shape = Vec::new();
    loop {
        let text = cursor.expect("the end of a data set 55")?;
        if text.trim() == "-1" {
            break;
        }
        let Some(&node) = cursor.integers(&text).first() else {
            return Err(cursor.fault(format!("expected the number of a node, found \"{}\"", text.trim())));
        };
        let mut values = Vec::new();
        while values.len() < usize::try_from(count).unwrap_or(0) {
            let text = cursor.expect("the values of a node")?;
            let found = numbers(&text, &[13; 6]);
            values.extend(
                found.ok_or_else(|| cursor.fault(format!("expected finite numbers, found \"{}\"", text.trim())))?,
            );
        }
        for (dof, value) in values.iter_mut().enumerate() {
            *value *= if dof < 3 { scale.metres } else { 1.0 } / (kilograms * scale.metres * scale.metres).sqrt();
        }
        shape.push((node, values));
    }
    Ok(Some(UffMode { frequency_hz, damping_ratio, shape }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_with_and_without_blanks_between() {
        assert_eq!(numbers("  1.50000E+00 -2.00000E+00", &[13; 6]), Some(vec![1.5, -2.0]));
        assert_eq!(numbers("-1.50000D+00-2.00000D+00", &[13; 6]), Some(vec![-1.5, -2.0]));
        assert_eq!(numbers(" 1.50000E+00 2.0", &[13; 6]), Some(vec![1.5, 2.0]));
        assert_eq!(numbers(" 1.50000E+00 x", &[13; 6]), None);
        assert_eq!(numbers(" 1.50000E+00 NaN", &[13; 6]), None);
        assert_eq!(numbers("", &[13; 6]), Some(vec![]));
    }
}
