//! Expressions over factors: arithmetic, comparisons, logic. For constraints and derived factors.
//!
//! In order of binding, the loosest first: `or` (`||`); `and` (`&&`); `not` (`!`); `==`, `!=`, `<`, `<=`, `>`, `>=`; `+`, `-`;
//! `*`, `/`, `%`; sign; `^` (to the right). Functions: `abs`, `sqrt`, `exp`, `ln`, `log10`, `sin`, `cos`, `tan`, `floor`,
//! `ceil`, `round`, `min`, `max`, `hypot`; others are the scope's. Names are letters, digits, `_` and dots; other names
//! stand in backticks. Texts stand in single or double quotes.

mod sides;

use std::fmt;

/// Deepest nesting: more is no expression that a person wrote.
const MAX_DEPTH: usize = 64;

/// Value of an expression.
#[derive(Debug, Clone, PartialEq)]
pub enum Outcome {
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// A truth value.
    Truth(bool),
}

impl fmt::Display for Outcome {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(formatter, "the number {number}"),
            Self::Text(text) => write!(formatter, "the text \"{text}\""),
            Self::Truth(truth) => write!(formatter, "{truth}"),
        }
    }
}

/// Source of the values of names.
pub trait Scope {
    /// Value of a name; the error contains the reason if there is none.
    fn value(&self, name: &str) -> Result<Outcome, String>;
    /// Value of a function that is not built in; its arguments are names or texts.
    fn call(&self, function: &str, arguments: &[&str]) -> Result<f64, String>;
}

/// Reason why a text is not an expression.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message} (character {column})")]
pub struct ExpressionError {
    /// Character at which the fault was seen, counted from 1.
    pub column: usize,
    /// The fault.
    pub message: String,
}

/// Role of a word in an expression.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Something that has a value.
    Value,
    /// A text in quotes.
    Text,
    /// A function of the scope.
    Function,
    /// An argument of such a function: a name, which may stand in quotes.
    Argument,
}

/// A word of an expression with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct Word {
    /// Character at which it stands, counted from 1.
    pub column: usize,
    /// The word, without quotes.
    pub text: String,
    /// Role of the word.
    pub role: Role,
}

/// A parsed expression.
#[derive(Debug, Clone, PartialEq)]
pub struct Expression {
    root: Node,
    words: Vec<Word>,
}

#[derive(Debug, Clone, PartialEq)]
enum Node {
    Constant(Outcome),
    Name(String),
    Call(String, Vec<Node>),
    Minus(Box<Node>),
    Not(Box<Node>),
    /// Operands that operators of one level join, from the left on: as flat as it is written, so that no sum is too long to be walked.
    Chain(Box<Node>, Vec<(&'static str, Node)>),
}

/// Binary operators by binding, the loosest first; each group binds to the left.
const LEVELS: [&[&str]; 5] =
    [&["or", "||"], &["and", "&&"], &["==", "!=", "<=", ">=", "<", ">"], &["+", "-"], &["*", "/", "%"]];
/// Level of the comparisons, above which `not` stands.
const COMPARISONS: usize = 2;

impl Expression {
    /// Parses an expression.
    ///
    /// # Errors
    /// [`ExpressionError`] with the place.
    pub fn parse(text: &str) -> Result<Self, ExpressionError> {
        let mut parser =
            Parser { tokens: tokens(text)?, next: 0, end: text.chars().count() + 1, depth: 0, words: Vec::new() };
        let root = parser.level(0)?;
        match parser.tokens.get(parser.next) {
            None => Ok(Self { root, words: parser.words }),
            Some((column, token)) => Err(ExpressionError {
                column: *column,
                message: format!("found `{token}` where the expression should end or an operator should stand"),
            }),
        }
    }

    /// The expression that is a number.
    pub fn constant(number: f64) -> Self {
        Self { root: Node::Constant(Outcome::Number(number)), words: Vec::new() }
    }

    /// Names and texts in order, without built-in functions.
    pub fn words(&self) -> &[Word] {
        &self.words
    }

    /// Names that the expression uses, arguments of the scope's functions apart; each once, in order.
    pub fn names(&self) -> Vec<&str> {
        let mut names = Vec::new();
        collect(&self.root, &mut names);
        names
    }

    /// Whether the expression calls a function that is not built in.
    pub fn calls_scope(&self) -> bool {
        calls_scope(&self.root)
    }

    /// The expression's value.
    ///
    /// # Errors
    /// The scope's; values that do not fit an operator; results that are no numbers.
    pub fn evaluate(&self, scope: &dyn Scope) -> Result<Outcome, String> {
        evaluate(&self.root, scope)
    }
}

fn collect<'a>(node: &'a Node, names: &mut Vec<&'a str>) {
    match node {
        Node::Name(name) if !names.contains(&name.as_str()) => names.push(name),
        Node::Call(function, arguments) if builtin(function) => {
            arguments.iter().for_each(|argument| collect(argument, names));
        }
        Node::Minus(inner) | Node::Not(inner) => collect(inner, names),
        Node::Chain(first, rest) => {
            collect(first, names);
            rest.iter().for_each(|(_, operand)| collect(operand, names));
        }
        Node::Name(_) | Node::Call(..) | Node::Constant(_) => {}
    }
}

fn calls_scope(node: &Node) -> bool {
    match node {
        Node::Call(function, arguments) => !builtin(function) || arguments.iter().any(calls_scope),
        Node::Minus(inner) | Node::Not(inner) => calls_scope(inner),
        Node::Chain(first, rest) => calls_scope(first) || rest.iter().any(|(_, operand)| calls_scope(operand)),
        Node::Name(_) | Node::Constant(_) => false,
    }
}

#[derive(Debug, Clone, PartialEq)]
enum Token {
    Number(f64),
    Text(String),
    Name(String),
    Symbol(&'static str),
}

impl fmt::Display for Token {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(number) => write!(formatter, "{number}"),
            Self::Text(text) | Self::Name(text) => write!(formatter, "{text}"),
            Self::Symbol(symbol) => write!(formatter, "{symbol}"),
        }
    }
}

/// Symbols, longer ones before their beginnings.
const SYMBOLS: [&str; 18] =
    ["==", "!=", "<=", ">=", "&&", "||", "<", ">", "+", "-", "*", "/", "%", "^", "(", ")", ",", "!"];
const WORDS: [&str; 3] = ["or", "and", "not"];

/// Tokens with the characters at which they start.
fn tokens(text: &str) -> Result<Vec<(usize, Token)>, ExpressionError> {
    let mut tokens = Vec::new();
    let mut rest = text;
    let mut column = 1;
    while let Some(first) = rest.chars().next() {
        let fault = |message: String| ExpressionError { column, message };
        let length = if first.is_whitespace() {
            first.len_utf8()
        } else if matches!(first, '\'' | '"' | '`') {
            let inner = rest.get(1..).unwrap_or("");
            let end = inner.find(first).ok_or_else(|| fault(format!("the {first} is not closed")))?;
            let inner = inner.get(..end).unwrap_or("").to_string();
            tokens.push((column, if first == '`' { Token::Name(inner) } else { Token::Text(inner) }));
            end + 2
        } else if first.is_ascii_digit() || first == '.' {
            let length = number_length(rest);
            let digits = rest.get(..length).unwrap_or("");
            let number = digits.parse::<f64>().ok().filter(|number| number.is_finite());
            tokens.push((column, Token::Number(number.ok_or_else(|| fault(format!("`{digits}` is no number")))?)));
            length
        } else if first.is_ascii_alphabetic() || first == '_' {
            let end = |c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '.');
            let name = rest.get(..rest.find(end).unwrap_or(rest.len())).unwrap_or("");
            let word = WORDS.iter().find(|word| **word == name);
            tokens.push((column, word.map_or_else(|| Token::Name(name.to_string()), |word| Token::Symbol(word))));
            name.len()
        } else {
            let symbol = SYMBOLS.iter().find(|symbol| rest.starts_with(**symbol));
            let symbol = symbol.ok_or_else(|| fault(format!("`{first}` has no meaning here")))?;
            tokens.push((column, Token::Symbol(symbol)));
            symbol.len()
        };
        let (token, behind) = rest.split_at_checked(length).unwrap_or((rest, ""));
        column += token.chars().count();
        rest = behind;
    }
    Ok(tokens)
}

/// Length of the number at the start of a text: digits, a point, an exponent with its sign.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |from: usize| bytes.iter().skip(from).take_while(|b| b.is_ascii_digit() || **b == b'.').count();
    let mantissa = digits(0);
    if !matches!(bytes.get(mantissa), Some(b'e' | b'E')) {
        return mantissa;
    }
    let sign = usize::from(matches!(bytes.get(mantissa + 1), Some(b'+' | b'-')));
    match digits(mantissa + 1 + sign) {
        0 => mantissa,
        exponent => mantissa + 1 + sign + exponent,
    }
}

struct Parser {
    tokens: Vec<(usize, Token)>,
    next: usize,
    /// Column behind the text.
    end: usize,
    depth: usize,
    /// Names and texts so far.
    words: Vec<Word>,
}

impl Parser {
    fn fault<T>(&self, expected: &str) -> Result<T, ExpressionError> {
        let (column, found) = match self.tokens.get(self.next) {
            Some((column, token)) => (*column, format!("found `{token}`")),
            None => (self.end, "the expression ends".to_string()),
        };
        Err(ExpressionError { column, message: format!("{found}, expected {expected}") })
    }

    fn take(&mut self, symbols: &[&'static str]) -> Option<&'static str> {
        match self.tokens.get(self.next) {
            Some((_, Token::Symbol(symbol))) if symbols.contains(symbol) => {
                self.next += 1;
                Some(symbol)
            }
            _ => None,
        }
    }

    fn level(&mut self, level: usize) -> Result<Node, ExpressionError> {
        if level == COMPARISONS && self.take(&["not", "!"]).is_some() {
            return self.nested(|parser| Ok(Node::Not(Box::new(parser.level(COMPARISONS)?))));
        }
        let Some(symbols) = LEVELS.get(level) else { return self.sign() };
        let first = self.level(level + 1)?;
        let mut rest = Vec::new();
        while let Some(symbol) = self.take(symbols) {
            rest.push((symbol, self.level(level + 1)?));
            if level == COMPARISONS
                && matches!(self.tokens.get(self.next), Some((_, Token::Symbol(s))) if symbols.contains(s))
            {
                return self.fault("`and`: comparisons are not chained (write `a < b and b < c`)");
            }
        }
        Ok(if rest.is_empty() { first } else { Node::Chain(Box::new(first), rest) })
    }

    fn sign(&mut self) -> Result<Node, ExpressionError> {
        match self.take(&["-", "+"]) {
            Some("-") => self.nested(|parser| Ok(Node::Minus(Box::new(parser.sign()?)))),
            Some(_) => self.nested(Self::sign),
            None => {
                let base = self.primary()?;
                if self.take(&["^"]).is_none() {
                    return Ok(base);
                }
                let exponent = self.nested(Self::sign)?;
                Ok(Node::Chain(Box::new(base), vec![("^", exponent)]))
            }
        }
    }

    fn nested<T>(&mut self, inner: impl FnOnce(&mut Self) -> Result<T, ExpressionError>) -> Result<T, ExpressionError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return self.fault("a shorter expression: this one is nested too deeply");
        }
        let result = inner(self)?;
        self.depth -= 1;
        Ok(result)
    }

    fn primary(&mut self) -> Result<Node, ExpressionError> {
        if self.take(&["("]).is_some() {
            let inner = self.nested(|parser| parser.level(0))?;
            return if self.take(&[")"]).is_some() { Ok(inner) } else { self.fault("`)`") };
        }
        let token = self.tokens.get(self.next).cloned();
        let node = match token {
            Some((_, Token::Number(number))) => Node::Constant(Outcome::Number(number)),
            Some((column, Token::Text(text))) => {
                self.words.push(Word { column, text: text.clone(), role: Role::Text });
                Node::Constant(Outcome::Text(text))
            }
            Some((column, Token::Name(name))) => {
                self.next += 1;
                return self.name(column, name);
            }
            _ => return self.fault("a number, a name or `(`"),
        };
        self.next += 1;
        Ok(node)
    }

    /// Parses a value or a function call.
    fn name(&mut self, column: usize, name: String) -> Result<Node, ExpressionError> {
        let word = |role: Role| Word { column, text: name.clone(), role };
        if self.take(&["("]).is_none() {
            self.words.push(word(Role::Value));
            return Ok(Node::Name(name));
        }
        if builtin(&name) {
            let arguments = self.arguments()?;
            return Ok(Node::Call(name, arguments));
        }
        self.words.push(word(Role::Function));
        let first = self.words.len();
        let arguments = self.arguments()?;
        for word in self.words.iter_mut().skip(first).filter(|word| word.role != Role::Function) {
            word.role = Role::Argument;
        }
        Ok(Node::Call(name, arguments))
    }

    /// Arguments up to the closing parenthesis; the opening one has been taken.
    fn arguments(&mut self) -> Result<Vec<Node>, ExpressionError> {
        let mut arguments = Vec::new();
        if self.take(&[")"]).is_some() {
            return Ok(arguments);
        }
        loop {
            arguments.push(self.nested(|parser| parser.level(0))?);
            if self.take(&[")"]).is_some() {
                return Ok(arguments);
            }
            if self.take(&[","]).is_none() {
                return self.fault("`,` or `)`");
            }
        }
    }
}

const ONE_ARGUMENT: [&str; 11] = ["abs", "sqrt", "exp", "ln", "log10", "sin", "cos", "tan", "floor", "ceil", "round"];
const MORE_ARGUMENTS: [&str; 3] = ["min", "max", "hypot"];

fn builtin(function: &str) -> bool {
    ONE_ARGUMENT.contains(&function) || MORE_ARGUMENTS.contains(&function)
}

fn evaluate(node: &Node, scope: &dyn Scope) -> Result<Outcome, String> {
    Ok(match node {
        Node::Constant(value) => value.clone(),
        Node::Name(name) => scope.value(name)?,
        Node::Minus(inner) => Outcome::Number(-number(inner, scope)?),
        Node::Not(inner) => Outcome::Truth(!truth(inner, scope)?),
        Node::Call(function, arguments) => Outcome::Number(call(function, arguments, scope)?),
        Node::Chain(first, rest) => {
            let mut left = evaluate(first, scope)?;
            for (symbol, right) in rest {
                left = joined(left, symbol, (right, scope))?;
            }
            left
        }
    })
}

/// Applies an operator to a value and the operand behind it. The operand is not evaluated if the value decides.
fn joined(left: Outcome, symbol: &str, (right, scope): (&Node, &dyn Scope)) -> Result<Outcome, String> {
    Ok(match symbol {
        "or" | "||" => Outcome::Truth(as_truth(left)? || truth(right, scope)?),
        "and" | "&&" => Outcome::Truth(as_truth(left)? && truth(right, scope)?),
        "==" | "!=" => {
            let right = evaluate(right, scope)?;
            if std::mem::discriminant(&left) != std::mem::discriminant(&right) {
                return Err(format!("`{symbol}` compares {left} with {right}"));
            }
            Outcome::Truth((left == right) == (symbol == "=="))
        }
        _ => binary(symbol, as_number(left)?, number(right, scope)?)?,
    })
}

fn binary(symbol: &str, left: f64, right: f64) -> Result<Outcome, String> {
    let result = match symbol {
        "<" => return Ok(Outcome::Truth(left < right)),
        "<=" => return Ok(Outcome::Truth(left <= right)),
        ">" => return Ok(Outcome::Truth(left > right)),
        ">=" => return Ok(Outcome::Truth(left >= right)),
        "+" => left + right,
        "-" => left - right,
        "*" => left * right,
        "/" => left / right,
        "%" => left.rem_euclid(right),
        _ => libm::pow(left, right),
    };
    finite(result, || format!("{left} {symbol} {right}")).map(Outcome::Number)
}

fn finite(result: f64, what: impl Fn() -> String) -> Result<f64, String> {
    if result.is_finite() { Ok(result) } else { Err(format!("`{}` is {result}", what())) }
}

fn number(node: &Node, scope: &dyn Scope) -> Result<f64, String> {
    as_number(evaluate(node, scope)?)
}

fn as_number(value: Outcome) -> Result<f64, String> {
    match value {
        Outcome::Number(number) => Ok(number),
        other => Err(format!("expected a number, found {other}")),
    }
}

fn truth(node: &Node, scope: &dyn Scope) -> Result<bool, String> {
    as_truth(evaluate(node, scope)?)
}

fn as_truth(value: Outcome) -> Result<bool, String> {
    match value {
        Outcome::Truth(truth) => Ok(truth),
        other => Err(format!("expected a comparison, found {other}")),
    }
}

fn call(function: &str, arguments: &[Node], scope: &dyn Scope) -> Result<f64, String> {
    if !builtin(function) {
        let name = |argument: &'_ Node| match argument {
            Node::Name(name) | Node::Constant(Outcome::Text(name)) => Ok(name.clone()),
            _ => Err(format!("the arguments of `{function}` are names")),
        };
        let names = arguments.iter().map(name).collect::<Result<Vec<String>, _>>()?;
        return scope.call(function, &names.iter().map(String::as_str).collect::<Vec<_>>());
    }
    let values = arguments.iter().map(|argument| number(argument, scope)).collect::<Result<Vec<f64>, _>>()?;
    let result = match (function, values.as_slice()) {
        ("abs", [x]) => x.abs(),
        ("sqrt", [x]) => x.sqrt(),
        ("exp", [x]) => libm::exp(*x),
        ("ln", [x]) => libm::log(*x),
        ("log10", [x]) => libm::log10(*x),
        ("sin", [x]) => libm::sin(*x),
        ("cos", [x]) => libm::cos(*x),
        ("tan", [x]) => libm::tan(*x),
        ("floor", [x]) => x.floor(),
        ("ceil", [x]) => x.ceil(),
        ("round", [x]) => x.round(),
        ("min", [first, rest @ ..]) => rest.iter().copied().fold(*first, f64::min),
        ("max", [first, rest @ ..]) => rest.iter().copied().fold(*first, f64::max),
        ("hypot", [x, y]) => libm::hypot(*x, *y),
        _ => return Err(format!("`{function}` does not take {} arguments", values.len())),
    };
    finite(result, || format!("{function} of {values:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Fixed;

    impl Scope for Fixed {
        fn value(&self, name: &str) -> Result<Outcome, String> {
            match name {
                "a" => Ok(Outcome::Number(2.0)),
                "b.c" | "x-y" => Ok(Outcome::Number(3.0)),
                "mount" => Ok(Outcome::Text("R3".into())),
                _ => Err(format!("no `{name}`")),
            }
        }

        fn call(&self, function: &str, arguments: &[&str]) -> Result<f64, String> {
            if function == "distance" { Ok(arguments.len() as f64) } else { Err(format!("no function {function}")) }
        }
    }

    fn value(text: &str) -> Result<Outcome, String> {
        Expression::parse(text).map_err(|error| error.to_string())?.evaluate(&Fixed)
    }

    #[test]
    fn arithmetic_binds_as_usual() {
        for (text, expected) in [
            ("1 + 2 * 3", 7.0),
            ("(1 + 2) * 3", 9.0),
            ("-2 ^ 2", -4.0),
            ("2 ^ 3 ^ 2", 512.0),
            ("2 ^ -1", 0.5),
            ("7 - 2 - 1", 4.0),
            ("8 / 4 / 2", 1.0),
            ("-7 % 3", 2.0),
            ("a * b.c + `x-y`", 9.0),
            ("max(1, a, min(5, 4)) + hypot(3, 4)", 9.0),
            ("1.5e-1 * 10", 1.5),
            ("distance(left, 'right one')", 2.0),
        ] {
            assert_eq!(value(text), Ok(Outcome::Number(expected)), "{text}");
        }
    }

    #[test]
    fn words_have_their_places() {
        let words = |text: &str| {
            let expression = Expression::parse(text).expect("an expression");
            let word = |word: &Word| (word.column, word.text.clone(), word.role);
            expression.words().iter().map(word).collect::<Vec<_>>()
        };
        assert_eq!(
            words("abs(a) > 1 and distance(left, 'right') < b.c"),
            [
                (5, "a".to_owned(), Role::Value),
                (16, "distance".to_owned(), Role::Function),
                (25, "left".to_owned(), Role::Argument),
                (31, "right".to_owned(), Role::Argument),
                (42, "b.c".to_owned(), Role::Value),
            ]
        );
        assert_eq!(words("mount == 'R3'")[1], (10, "R3".to_owned(), Role::Text));
    }

    #[test]
    fn logic_and_comparisons() {
        for (text, expected) in [
            ("a < 3 and b.c >= 3", true),
            ("not a < 3 or a > 1", true),
            ("a == 2 || unknown == 1", true),
            ("a == 3 && unknown == 1", false),
            ("mount == 'R3' && mount != \"R4\"", true),
            ("! (a > 1)", false),
        ] {
            assert_eq!(value(text), Ok(Outcome::Truth(expected)), "{text}");
        }
        assert_eq!(value("unknown > 1"), Err("no `unknown`".into()));
    }

    #[test]
    fn faults_have_places_and_never_panic() {
        for (text, column, words) in [
            ("1 +", 4, "the expression ends"),
            ("1 + * 2", 5, "found `*`"),
            ("a < b.c < 3", 9, "not chained"),
            ("'open", 1, "not closed"),
            ("2 $ 3", 3, "has no meaning"),
            ("(1", 3, "expected `)`"),
            ("1 2", 3, "operator"),
            ("", 1, "the expression ends"),
            ("1.2.3", 1, "is no number"),
        ] {
            let error = Expression::parse(text).unwrap_err();
            assert_eq!(error.column, column, "{text}: {error}");
            assert!(error.message.contains(words), "{text}: {error}");
        }
        assert!(Expression::parse(&"(".repeat(100_000)).is_err());
        assert!(Expression::parse(&"-".repeat(100_000)).is_err());
        // Any length: text without nesting is not walked level by level.
        let long = "a".to_owned() + &" + a".repeat(99_999);
        assert_eq!(value(&long), Ok(Outcome::Number(200_000.0)));
        assert_eq!(value(&("a > 1".to_owned() + &" and a > 1".repeat(50_000))), Ok(Outcome::Truth(true)));
        for text in ["1 / 0", "sqrt(-1)", "mount + 1", "a and 1", "mount < 'R4'", "a == mount", "sin()", "far(a)"] {
            assert!(value(text).is_err(), "{text}");
        }
    }
}
