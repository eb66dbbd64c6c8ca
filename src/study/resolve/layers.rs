//! Hammer parameters in layers: built-in hammer, hammer file, values of the study.

use toml::Value;

/// Keys of one table that state the same property in different ways. The first is always there; another one takes its
/// place, so a layer that states the property anew must not leave it to one of the layer below.
const ALTERNATIVES: [&[&str]; 2] =
    [&["damping_n_s_per_m", "restitution", "damping_s_per_m"], &["stiffness_n_per_m", "power_stiffness_n_per_m_n"]];

/// A layer that states a property twice.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Conflict {
    /// Path of the second statement within the layer.
    pub path: Vec<String>,
    /// The fault.
    pub message: String,
}

/// Lays `over` over `base`: tables are merged, everything else is replaced, and alternatives to new values are removed.
///
/// # Errors
/// [`Conflict`] if one table of `over` holds two alternatives.
pub(crate) fn lay(base: &mut toml::Table, over: &toml::Table) -> Result<(), Conflict> {
    lay_at(base, over, &mut Vec::new())
}

fn lay_at(base: &mut toml::Table, over: &toml::Table, at: &mut Vec<String>) -> Result<(), Conflict> {
    for group in ALTERNATIVES {
        let mut given = group.iter().filter(|key| over.contains_key(**key));
        let (Some(first), second) = (given.next(), given.next()) else { continue };
        if let Some(second) = second {
            let mut path = at.clone();
            path.push((*second).to_string());
            return Err(Conflict { path, message: format!("cannot be combined with `{first}`: give one of the two") });
        }
        group.iter().skip(1).for_each(|key| drop(base.remove(*key)));
    }
    for (key, value) in over {
        match (base.get_mut(key), value) {
            (Some(Value::Table(inner)), Value::Table(outer)) => {
                at.push(key.clone());
                lay_at(inner, outer, at)?;
                at.pop();
            }
            _ => {
                base.insert(key.clone(), value.clone());
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layers(base: &str, over: &str) -> Result<toml::Table, Conflict> {
        let mut values: toml::Table = toml::from_str(base).unwrap();
        lay(&mut values, &toml::from_str(over).unwrap())?;
        Ok(values)
    }

    #[test]
    fn tables_merge_and_values_are_replaced() {
        let found = layers("a.b = 1\na.c = 2", "a.b = 3\nd = [1]").unwrap();
        assert_eq!(found, toml::from_str::<toml::Table>("a.b = 3\na.c = 2\nd = [1]").unwrap());
    }

    /// A loss or stiffness stated anew counts, in whichever way the layer below has stated it.
    #[test]
    fn alternatives_displace_each_other() {
        let base = "a.damping_n_s_per_m = 1\na.restitution = 0.5\na.exponent = 2";
        let damped = layers(base, "a.damping_n_s_per_m = 7").unwrap();
        assert_eq!(damped, toml::from_str::<toml::Table>("a.damping_n_s_per_m = 7\na.exponent = 2").unwrap());
        let crossley = layers(base, "a.damping_s_per_m = 7").unwrap();
        assert!(!crossley["a"].as_table().unwrap().contains_key("restitution"));
        assert_eq!(layers(base, "a.exponent = 3").unwrap()["a"]["restitution"].as_float(), Some(0.5));
        let conflict = layers(base, "a.damping_n_s_per_m = 7\na.restitution = 0.5").unwrap_err();
        assert_eq!(conflict.path, ["a", "restitution"]);
        assert!(conflict.message.contains("`damping_n_s_per_m`"), "{}", conflict.message);
    }
}
