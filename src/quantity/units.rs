//! Units of a study's keys, and the units that are converted to them.
//!
//! A key's unit is the ending of its name: `supply_bar` is in bar, `stiffness_n_per_m` in N/m.

/// Endings of keys with their units; the first that matches counts.
const ENDINGS: [(&str, &str); 18] = [
    ("_n_per_m_n", "N/m^n"),
    ("_j_per_kg_k", "J/(kg K)"),
    ("_n_s_per_m", "N s/m"),
    ("_n_per_m", "N/m"),
    ("_s_per_m", "s/m"),
    ("_kg_m2", "kg m2"),
    ("_m_s2", "m/s2"),
    ("_m_s", "m/s"),
    ("_m2", "m2"),
    ("_m3", "m3"),
    ("_bar", "bar"),
    ("_pa", "Pa"),
    ("_hz", "Hz"),
    ("_kg", "kg"),
    ("_m", "m"),
    ("_s", "s"),
    ("_n", "N"),
    ("_k", "K"),
];

/// Unit of numbers that have none.
pub const NO_UNIT: &str = "1";

/// Another unit of the same quantity: one of it is `factor` of the key's unit; `offset` is added.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conversion {
    /// Key's units in one of the other unit.
    pub factor: f64,
    /// Value in the key's unit of a zero in the other unit.
    pub offset: f64,
}

/// Zero degrees Celsius, K.
const CELSIUS_K: f64 = 273.15;
/// Zero degrees Fahrenheit, K.
const FAHRENHEIT_K: f64 = 459.67 / 1.8;
/// Pound-force per square inch, Pa.
const PSI_PA: f64 = 6_894.757_293_168_361;
/// Pound, kg.
const POUND_KG: f64 = 0.453_592_37;
/// Pound-force, N.
const POUND_FORCE_N: f64 = 4.448_221_615_260_5;
/// Inch, m.
const INCH_M: f64 = 0.0254;
/// Standard gravity, m/s2.
const GRAVITY_M_S2: f64 = 9.806_65;

/// Other units of a key's unit: name and conversion.
fn others(unit: &str) -> &'static [(&'static str, f64, f64)] {
    match unit {
        "m" => &[("mm", 1e-3, 0.0), ("cm", 1e-2, 0.0), ("um", 1e-6, 0.0), ("in", INCH_M, 0.0), ("ft", 0.3048, 0.0)],
        "m2" => &[("mm2", 1e-6, 0.0), ("cm2", 1e-4, 0.0), ("in2", INCH_M * INCH_M, 0.0)],
        "m3" => &[("mm3", 1e-9, 0.0), ("cm3", 1e-6, 0.0), ("l", 1e-3, 0.0)],
        "m/s" => &[("mm/s", 1e-3, 0.0), ("cm/s", 1e-2, 0.0), ("in/s", INCH_M, 0.0)],
        "m/s2" => &[("mm/s2", 1e-3, 0.0), ("g", GRAVITY_M_S2, 0.0)],
        "kg" => &[("g", 1e-3, 0.0), ("t", 1e3, 0.0), ("lb", POUND_KG, 0.0)],
        "kg m2" => &[("kg mm2", 1e-6, 0.0), ("kg cm2", 1e-4, 0.0), ("g mm2", 1e-9, 0.0)],
        "s" => &[("ms", 1e-3, 0.0), ("us", 1e-6, 0.0), ("min", 60.0, 0.0)],
        "Hz" => &[("kHz", 1e3, 0.0)],
        "bar" => &[
            ("mbar", 1e-3, 0.0),
            ("Pa", 1e-5, 0.0),
            ("hPa", 1e-3, 0.0),
            ("kPa", 1e-2, 0.0),
            ("MPa", 10.0, 0.0),
            ("psi", PSI_PA * 1e-5, 0.0),
        ],
        "Pa" => &[
            ("hPa", 1e2, 0.0),
            ("kPa", 1e3, 0.0),
            ("MPa", 1e6, 0.0),
            ("mbar", 1e2, 0.0),
            ("bar", 1e5, 0.0),
            ("psi", PSI_PA, 0.0),
        ],
        "N" => &[("kN", 1e3, 0.0), ("lbf", POUND_FORCE_N, 0.0)],
        "N/m" => &[("kN/m", 1e3, 0.0), ("MN/m", 1e6, 0.0), ("N/mm", 1e3, 0.0), ("kN/mm", 1e6, 0.0), ("N/um", 1e6, 0.0)],
        "N s/m" => &[("kN s/m", 1e3, 0.0), ("N s/mm", 1e3, 0.0)],
        "s/m" => &[("s/mm", 1e3, 0.0)],
        "K" => &[("degC", 1.0, CELSIUS_K), ("degF", 1.0 / 1.8, FAHRENHEIT_K)],
        "J/(kg K)" => &[("kJ/(kg K)", 1e3, 0.0)],
        NO_UNIT => &[("%", 1e-2, 0.0)],
        _ => &[],
    }
}

/// Unit of a key by its name; [`NO_UNIT`] for a number without one.
pub fn unit_of_key(key: &str) -> &'static str {
    ENDINGS.iter().find(|(ending, _)| key.ends_with(ending)).map_or(NO_UNIT, |(_, unit)| unit)
}

/// Units that a factor of a key with this unit can have, the key's own first.
pub fn accepted(unit: &'static str) -> impl Iterator<Item = &'static str> {
    std::iter::once(unit).chain(others(unit).iter().map(|(name, ..)| *name))
}

/// Conversion of numbers in the unit `from` to a key's unit `to`; `None` for a unit of another quantity.
pub fn conversion(from: &str, to: &str) -> Option<Conversion> {
    let wanted = plain(from);
    if wanted == plain(to) || (to == NO_UNIT && ["", "-"].contains(&wanted.as_str())) {
        return Some(Conversion { factor: 1.0, offset: 0.0 });
    }
    let found = others(to).iter().find(|(name, ..)| plain(name) == wanted);
    found.map(|(_, factor, offset)| Conversion { factor: *factor, offset: *offset })
}

/// All units of keys, with the ending of their names.
pub fn endings() -> impl Iterator<Item = (&'static str, &'static str)> {
    ENDINGS.into_iter().rev()
}

/// A unit in one spelling: `N*s/m`, `N·s/m` and `Ns/m` are the same, and so are `m^2` and `m²`, and `°C` and `degC`.
fn plain(unit: &str) -> String {
    let plain = unit.replace('²', "2").replace('³', "3").replace("\u{b0}", "deg").replace(['\u{3bc}', 'µ'], "u");
    let plain: String = plain.chars().filter(|c| !c.is_whitespace() && !"^*·".contains(*c)).collect();
    match plain.as_str() {
        "barg" | "bar(g)" => "bar".to_owned(),
        "psig" => "psi".to_owned(),
        "C" => "degC".to_owned(),
        "F" => "degF".to_owned(),
        _ => plain,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_s_unit_is_the_ending_of_its_name() {
        let units =
            ["supply_bar", "rail_position_m", "stiffness_n_per_m", "damping_n_s_per_m", "inertia_kg_m2", "restitution"];
        assert_eq!(units.map(unit_of_key), ["bar", "m", "N/m", "N s/m", "kg m2", "1"]);
    }

    /// Against figures of NIST SP 811, appendix B.
    #[test]
    fn units_are_converted() {
        let converted = |value: f64, from, to| {
            let Conversion { factor, offset } = conversion(from, to).unwrap_or_else(|| panic!("{from} to {to}"));
            factor * value + offset
        };
        for (value, from, to, expected) in [
            (1.0, "psi", "bar", 0.068_947_57),
            (14.695_95, "psi", "Pa", 101_325.0),
            (1.0, "lb", "kg", 0.453_592_4),
            (1.0, "lbf", "N", 4.448_222),
            (20.0, "degC", "K", 293.15),
            (68.0, "°F", "K", 293.15),
            (1.0, "N/µm", "N/m", 1e6),
            (3.0, "Ns/mm", "N s/m", 3e3),
            (2.0, "in", "m", 0.0508),
            (500.0, "kPa", "bar", 5.0),
        ] {
            let found = converted(value, from, to);
            assert!((found / expected - 1.0).abs() < 1e-6, "{value} {from}: {found} {to}, not {expected}");
        }
        assert_eq!(conversion("bar", "bar"), Some(Conversion { factor: 1.0, offset: 0.0 }));
        assert_eq!(conversion("kg m^2", "kg m2"), Some(Conversion { factor: 1.0, offset: 0.0 }));
        assert_eq!(conversion("mm", "bar"), None);
    }

    #[test]
    fn names_are_told_apart() {
        for unit in ENDINGS.map(|(_, unit)| unit) {
            let names: Vec<String> = accepted(unit).map(plain).collect();
            let mut different = names.clone();
            different.sort();
            different.dedup();
            assert_eq!(different.len(), names.len(), "{names:?}");
        }
    }
}
