//! The sides of a comparison, and the units of an expression.

use super::{Expression, Node, Outcome};

/// A unit; `None`: a number without one, or a product or function, whose unit is not worked out.
type Unit = Option<String>;

impl Expression {
    /// The two sides of a comparison with its operator; `None` for any other expression.
    pub fn comparison(&self) -> Option<(Self, &'static str, Self)> {
        let Node::Chain(left, rest) = &self.root else { return None };
        let [(symbol, right)] = rest.as_slice() else { return None };
        let side = |node: &Node| Self { root: node.clone(), words: Vec::new() };
        ["<=", "<", ">=", ">"].contains(symbol).then(|| (side(left), *symbol, side(right)))
    }

    /// The name that the expression consists of; `None` for any other expression.
    pub fn single_name(&self) -> Option<&str> {
        match &self.root {
            Node::Name(name) => Some(name),
            _ => None,
        }
    }

    /// Unit of the value, if it follows from sums and single names. `of`: units of names.
    ///
    /// # Errors
    /// A sum, a comparison, `min`, `max` or `hypot` of different units.
    pub fn unit(&self, of: &dyn Fn(&str) -> Option<String>) -> Result<Option<String>, String> {
        unit(&self.root, of)
    }
}

fn unit(node: &Node, of: &dyn Fn(&str) -> Unit) -> Result<Unit, String> {
    match node {
        Node::Constant(Outcome::Number(_) | Outcome::Text(_) | Outcome::Truth(_)) => Ok(None),
        Node::Name(name) => Ok(of(name)),
        Node::Minus(inner) => unit(inner, of),
        Node::Not(inner) => unit(inner, of).map(|_| None),
        Node::Call(function, arguments) => {
            let units = arguments.iter().map(|argument| unit(argument, of)).collect::<Result<Vec<Unit>, String>>()?;
            match function.as_str() {
                "min" | "max" | "hypot" => same(units, function),
                "abs" | "round" | "floor" | "ceil" => Ok(units.into_iter().next().flatten()),
                _ => Ok(None),
            }
        }
        Node::Chain(first, rest) => {
            let mut left = unit(first, of)?;
            for (symbol, right) in rest {
                let right = unit(right, of)?;
                left = match *symbol {
                    "+" | "-" | "%" => same(vec![left, right], symbol)?,
                    "==" | "!=" | "<=" | ">=" | "<" | ">" => same(vec![left, right], symbol).map(|_| None)?,
                    _ => None,
                };
            }
            Ok(left)
        }
    }
}

/// Common unit of operands; numbers without a unit take the unit of the others.
fn same(units: Vec<Unit>, operator: &str) -> Result<Unit, String> {
    let mut known = units.into_iter().flatten();
    let Some(first) = known.next() else { return Ok(None) };
    match known.find(|other| *other != first) {
        Some(other) => Err(format!("`{operator}` joins values in {first} and {other}")),
        None => Ok(Some(first)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_sums_must_agree() {
        let of = |name: &str| match name {
            "work_j" | "loss_j" => Some("J".to_owned()),
            "speed" => Some("m/s".to_owned()),
            _ => None,
        };
        let unit = |text: &str| Expression::parse(text).map_err(|error| error.to_string())?.unit(&of);
        assert_eq!(unit("work_j - 2 * loss_j + 3"), Ok(Some("J".to_owned())));
        assert_eq!(unit("min(work_j, loss_j) <= 5"), Ok(None));
        assert_eq!(unit("work_j / speed"), Ok(None));
        assert_eq!(unit("work_j - speed"), Err("`-` joins values in J and m/s".to_owned()));
        assert_eq!(unit("work_j <= speed"), Err("`<=` joins values in J and m/s".to_owned()));
    }

    #[test]
    fn a_comparison_has_two_sides() {
        let sides = |text: &str| Expression::parse(text).ok()?.comparison();
        let (left, symbol, right) = sides("a + b <= 2").expect("a comparison");
        assert_eq!((left.names(), symbol, right), (vec!["a", "b"], "<=", Expression::constant(2.0)));
        assert!(sides("a + 2").is_none() && sides("a == 2").is_none() && sides("a < 1 and b < 2").is_none());
    }
}
