//! Commented study of `init`: handwritten text, completed from the declarations of parameters.

use serde::Serialize;
use serde::ser::Error as _;
use toml::Table;
use toml::ser::Error;

use super::document::keys::{Shape, shape_at};
use super::schema::study_schema;
use decore_model::contact::{ContactLawName, ContactParameters};
use decore_model::hammer::HammerParameters;
use decore_model::parameter::{Parameter, ParameterKind, Parameters, lines};
use decore_model::scene::{
    Environment, HammerUnit, OutputSettings, Scene, SolverSettings, StructureParameters, Supply,
};
use decore_model::workpiece::{CastingStructure, Fixture};
use decore_statistics::design::DesignOptions;

/// The part by hand. A line `#! key` stands for the parameters of the table with that key.
const BY_HAND: &str = include_str!("../assets/study_template.toml");
/// Stands for a value that follows from others unless it is given.
const FOLLOWS: &str = "...";

/// A commented study that shows every key.
///
/// # Errors
/// A default that TOML cannot hold.
pub fn template() -> Result<String, Error> {
    let shape = Shape::from_schema(&study_schema());
    let mut text = BY_HAND.replace("#! contact\n", &contact()?);
    let duration = Table::from_iter([("duration_s".to_owned(), Scene::default().duration_s.into())]);
    complete::<Scene>(&mut text, "study", duration, &shape)?;
    complete::<StructureParameters>(&mut text, "structure", StructureParameters::default(), &shape)?;
    complete::<Supply>(&mut text, "supply", Supply::default(), &shape)?;
    complete::<HammerUnit>(&mut text, "hammer", HammerUnit::default(), &shape)?;
    complete::<Fixture>(&mut text, "fixture", Fixture::default(), &shape)?;
    complete::<CastingStructure>(&mut text, "casting_structure", CastingStructure::default(), &shape)?;
    complete::<SolverSettings>(&mut text, "solver", SolverSettings::default(), &shape)?;
    complete::<OutputSettings>(&mut text, "outputs", OutputSettings::default(), &shape)?;
    complete::<Environment>(&mut text, "environment", Environment::default(), &shape)?;
    let (kind, keys) = design(&shape)?;
    Ok(text.replace("#! kind\n", &kind).replace("#! design\n", &keys))
}

/// Keys of a contact, commented out, with the values of the contact that strikes the casting; derived ones have no value.
fn contact() -> Result<String, Error> {
    let laws: Vec<&str> = ContactLawName::ALL.iter().map(|law| law.name()).collect();
    let mut values = Table::try_from(HammerParameters::default().chisel.casting_contact)?;
    values.insert("law".to_owned(), ContactLawName::default().name().into());
    for entry in ContactParameters::ENTRIES {
        values.entry(entry.name).or_insert_with(|| FOLLOWS.into());
    }
    let more = |entry: &Parameter| match entry.kind {
        ParameterKind::Choice => Some(laws.join(", ")),
        _ => Some(entry.source.replace('`', "")),
    };
    Ok(lines(ContactParameters::ENTRIES, &values, "# ", &more)
        .replace(&format!("{FOLLOWS:?}"), &format!("{FOLLOWS}  ")))
}

/// The line with the kind of design, and the keys of designs, commented out; `rows` is written by hand, for the kind shown needs it.
fn design(shape: &Shape) -> Result<(String, String), Error> {
    let entry = |name: &'static str, text: &'static [&'static str]| Parameter {
        name,
        text,
        values: "",
        source: "",
        kind: ParameterKind::Choice,
    };
    let kind = [entry("kind", &["How the rows are chosen"])];
    let at = ["design", "kind"].map(str::to_owned);
    let kinds = |_: &Parameter| shape_at(shape, &Table::new(), &at).ok().map(Shape::words);
    let values = Table::from_iter([("kind".to_owned(), "latin_hypercube".into())]);
    let keys = DesignOptions::KEYS.iter().filter(|key| key.name != "rows");
    let entries: Vec<Parameter> = keys.clone().map(|key| entry(key.name, key.text)).collect();
    let shown: String = keys.map(|key| format!("{} = {}\n", key.name, key.shown)).collect();
    let shown: Table = toml::from_str(&shown).map_err(|error| Error::custom(error.to_string()))?;
    Ok((lines(&kind, &values, "", &kinds), lines(&entries, &shown, "# ", &|_| None)))
}

/// Puts the parameters of a table in their place, commented out, with the values they have by default.
fn complete<T: Parameters>(text: &mut String, table: &str, values: impl Serialize, shape: &Shape) -> Result<(), Error> {
    let choices = |entry: &Parameter| {
        let at = [table, entry.name].map(str::to_owned);
        let shape = shape_at(shape, &Table::new(), &at).ok().filter(|_| matches!(entry.kind, ParameterKind::Choice));
        shape.map(Shape::words)
    };
    *text = text.replace(&format!("#! {table}\n"), &lines(T::ENTRIES, &Table::try_from(values)?, "# ", &choices));
    Ok(())
}
