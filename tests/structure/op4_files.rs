//! Small OUTPUT4 files of every kind, written as the format's description has it.

/// A matrix by rows.
#[derive(Debug, Clone)]
pub struct Matrix {
    name: &'static str,
    rows: Vec<Vec<f64>>,
    complex: bool,
}

impl Matrix {
    pub fn real(name: &'static str, rows: Vec<Vec<f64>>) -> Self {
        Self { name, rows, complex: false }
    }

    /// The imaginary part is twice the real one.
    pub fn complex(name: &'static str, rows: Vec<Vec<f64>>) -> Self {
        Self { name, rows, complex: true }
    }

    /// Numbers of a column from its first to its last row that is not 0.
    fn column(&self, column: usize) -> Option<(usize, Vec<f64>)> {
        let first = self.rows.iter().position(|row| row[column] != 0.0)?;
        let last = self.rows.iter().rposition(|row| row[column] != 0.0)?;
        Some((first, self.rows[first..=last].iter().map(|row| row[column]).collect()))
    }

    /// Runs of numbers of a column that are not 0.
    fn strings(&self, column: usize) -> Vec<(usize, Vec<f64>)> {
        let mut out: Vec<(usize, Vec<f64>)> = Vec::new();
        for (row, value) in self.rows.iter().map(|row| row[column]).enumerate().filter(|(_, value)| *value != 0.0) {
            match out.last_mut() {
                Some((first, values)) if *first + values.len() == row => values.push(value),
                _ => out.push((row, vec![value])),
            }
        }
        out
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Columns {
    Dense,
    Big,
    NotBig,
}

/// How a file is written.
#[derive(Debug, Clone, Copy)]
pub struct Form {
    /// Byte order and size of integers; none: text.
    binary: Option<(bool, usize)>,
    double: bool,
    columns: Columns,
}

impl Form {
    pub fn all() -> Vec<Self> {
        let media = [None, Some((true, 4)), Some((true, 8)), Some((false, 4)), Some((false, 8))];
        let columns = [Columns::Dense, Columns::Big, Columns::NotBig];
        let form = |binary, double, columns| Self { binary, double, columns };
        let of = |binary| [false, true].into_iter().flat_map(move |double| columns.map(|c| form(binary, double, c)));
        media.into_iter().flat_map(of).collect()
    }

    pub fn text() -> Self {
        Self { binary: None, double: true, columns: Columns::Dense }
    }

    pub fn binary() -> Self {
        Self { binary: Some((true, 4)), double: true, columns: Columns::NotBig }
    }

    /// Words that a number counts for.
    fn words(&self) -> usize {
        if self.double { 2 } else { 1 }
    }

    fn header(&self, matrix: &Matrix) -> [i64; 4] {
        let (rows, columns) = (matrix.rows.len() as i64, matrix.rows[0].len() as i64);
        let kind = i64::from(self.double) + 1 + if matrix.complex { 2 } else { 0 };
        [columns, if self.columns == Columns::Big { -rows } else { rows }, if rows == columns { 6 } else { 2 }, kind]
    }
}

/// Real and imaginary parts in turn, where there are any.
fn numbers(matrix: &Matrix, values: &[f64]) -> Vec<f64> {
    values.iter().flat_map(|value| if matrix.complex { vec![*value, 2.0 * value] } else { vec![*value] }).collect()
}

/// The head of a string, `length` in words.
fn head(form: &Form, length: usize, first: usize) -> Vec<i64> {
    match form.columns {
        Columns::Big => vec![length as i64 + 1, first as i64 + 1],
        _ => vec![(length as i64 + 1) * 65536 + first as i64 + 1],
    }
}

/// A file with these matrices.
pub fn file(matrices: &[Matrix], form: &Form) -> Vec<u8> {
    matrices
        .iter()
        .flat_map(|matrix| if form.binary.is_some() { binary(matrix, form) } else { text(matrix, form) })
        .collect()
}

fn text(matrix: &Matrix, form: &Form) -> Vec<u8> {
    let fields = |numbers: &[i64]| numbers.iter().map(|number| format!("{number:>8}")).collect::<String>() + "\n";
    let (digits, width) = if form.double { (15, 23) } else { (9, 16) };
    let value = |value: &f64| {
        let text = format!("{value:.digits$e}");
        let (mantissa, exponent) = text.split_once('e').expect("an exponent");
        let exponent: i32 = exponent.parse().expect("a number");
        format!("{:>width$}", format!("{mantissa}E{}{:02}", if exponent < 0 { '-' } else { '+' }, exponent.abs()))
    };
    let lines = |values: &[f64]| -> String {
        values.chunks(3).map(|line| line.iter().map(value).collect::<String>() + "\n").collect()
    };
    let header = form.header(matrix);
    let mut out = fields(&header);
    out.pop();
    out += &format!("{:<8}1P,3E{width}.{digits}\n", matrix.name);
    for column in 0..matrix.rows[0].len() {
        let number = column as i64 + 1;
        if form.columns == Columns::Dense {
            if let Some((first, values)) = matrix.column(column) {
                let values = numbers(matrix, &values);
                out += &(fields(&[number, first as i64 + 1, values.len() as i64]) + &lines(&values));
            }
            continue;
        }
        let strings: Vec<(Vec<i64>, Vec<f64>)> = matrix
            .strings(column)
            .into_iter()
            .map(|(first, values)| (first, numbers(matrix, &values)))
            .map(|(first, values)| (head(form, form.words() * values.len(), first), values))
            .collect();
        let words: usize = strings.iter().map(|(head, values)| head.len() + form.words() * values.len()).sum();
        if words > 0 {
            out += &fields(&[number, 0, words as i64]);
            strings.iter().for_each(|(head, values)| out += &(fields(head) + &lines(values)));
        }
    }
    (out + &fields(&[header[0] + 1, 1, 1]) + &lines(&[1.0])).into_bytes()
}

fn binary(matrix: &Matrix, form: &Form) -> Vec<u8> {
    let (little, size) = form.binary.expect("a binary form");
    let ordered = |mut bytes: Vec<u8>| {
        if !little {
            bytes.reverse();
        }
        bytes
    };
    let integers = |numbers: &[i64]| -> Vec<u8> {
        let bytes = |number: &i64| ordered(number.to_le_bytes()[..size].to_vec());
        numbers.iter().flat_map(bytes).collect()
    };
    let value = |value: &f64| -> Vec<u8> {
        let single = (*value as f32).to_le_bytes().to_vec();
        ordered(if size == 4 && !form.double { single } else { value.to_le_bytes().to_vec() })
    };
    let record = |body: &[u8]| -> Vec<u8> {
        let mark = ordered((body.len() as u32).to_le_bytes().to_vec());
        [&mark, body, &mark].concat()
    };
    let header = form.header(matrix);
    let name = format!("{:<8}", matrix.name);
    // Words of eight bytes hold four characters each.
    let name = if size == 8 { format!("{:<8}{:<8}", &name[..4], &name[4..]) } else { name };
    let mut out = record(&[integers(&header), name.into_bytes()].concat());
    for column in 0..matrix.rows[0].len() {
        let number = column as i64 + 1;
        let bytes = |values: &[f64]| values.iter().flat_map(value).collect::<Vec<u8>>();
        if form.columns == Columns::Dense {
            if let Some((first, values)) = matrix.column(column) {
                let values = numbers(matrix, &values);
                let head = [number, first as i64 + 1, (form.words() * values.len()) as i64];
                out.extend(record(&[integers(&head), bytes(&values)].concat()));
            }
            continue;
        }
        let (mut body, mut words) = (Vec::new(), 0);
        for (first, values) in matrix.strings(column) {
            let values = numbers(matrix, &values);
            let head = head(form, form.words() * values.len(), first);
            words += head.len() + form.words() * values.len();
            body.extend([integers(&head), bytes(&values)].concat());
        }
        if words > 0 {
            out.extend(record(&[integers(&[number, 0, words as i64]), body].concat()));
        }
    }
    let end = integers(&[header[0] + 1, 1, form.words() as i64]);
    out.extend(record(&[end, value(&1.0)].concat()));
    out
}
