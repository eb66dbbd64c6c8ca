//! Croissant metadata (MLCommons, version 1.0): files with checksums, for catalogues and loaders of data sets.

use hmac_sha256::Hash;
use serde_json::{Value, json};

use super::column::FeatureColumn;
use decore_dataset::Manifest;
use decore_quantity::Kind;

/// A file as others find it whole.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Described {
    /// Name of the file.
    pub name: &'static str,
    /// Size of the file in bytes.
    pub bytes: usize,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

impl Described {
    /// The file of this name with these bytes.
    pub fn of(name: &'static str, bytes: &[u8]) -> Self {
        let sha256 = Hash::hash(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
        Self { name, bytes: bytes.len(), sha256 }
    }

    fn encoding(&self) -> &'static str {
        match self.name.rsplit('.').next() {
            Some("parquet") => "application/x-parquet",
            Some("csv") => "text/csv",
            _ => "application/json",
        }
    }
}

/// The metadata of a table in the first of `files`.
pub(super) fn croissant(manifest: &Manifest, columns: &[FeatureColumn], files: &[Described]) -> String {
    let info = &manifest.study;
    let table = files.first().map_or("", |file| file.name);
    let distribution: Vec<Value> = files.iter().map(file_object).collect();
    let fields: Vec<Value> = columns.iter().map(|column| field(table, column)).collect();
    let about = format!(
        "Simulated pneumatic de-coring: a row per run of the study `{}` and casting, computed by decore {} (study hash {}).",
        info.study_name, info.program_version, info.study_hash
    );
    let metadata = json!({
        "@context": context(),
        "@type": "sc:Dataset",
        "name": info.study_name,
        "description": about,
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "version": info.program_version,
        "isLiveDataset": !manifest.complete,
        "distribution": distribution,
        "recordSet": [{
            "@type": "cr:RecordSet",
            "@id": "features",
            "name": "features",
            "description": "A row per run and casting.",
            "key": [{ "@id": "features/row" }, { "@id": "features/casting" }],
            "field": fields,
        }],
    });
    format!("{metadata:#}\n")
}

fn file_object(file: &Described) -> Value {
    json!({
        "@type": "cr:FileObject",
        "@id": file.name,
        "name": file.name,
        "contentUrl": file.name,
        "contentSize": format!("{} B", file.bytes),
        "encodingFormat": file.encoding(),
        "sha256": file.sha256,
    })
}

fn field(table: &str, column: &FeatureColumn) -> Value {
    let unit = if column.unit.is_empty() { String::new() } else { format!(" Unit: {}.", column.unit) };
    json!({
        "@type": "cr:Field",
        "@id": format!("features/{}", column.name),
        "name": column.name,
        "description": format!("{}{unit} Role: {}. Formula: {}.", column.description, column.role.name(), column.formula),
        "dataType": match column.values.kind() {
            Kind::Real => "sc:Float",
            Kind::Count | Kind::Integer => "sc:Integer",
            Kind::Text | Kind::Category => "sc:Text",
        },
        "source": { "fileObject": { "@id": table }, "extract": { "column": column.name } },
    })
}

/// The context that the specification prescribes.
fn context() -> Value {
    let mut context = json!({
        "@language": "en",
        "@vocab": "https://schema.org/",
        "sc": "https://schema.org/",
        "cr": "http://mlcommons.org/croissant/",
        "rai": "http://mlcommons.org/croissant/RAI/",
        "dct": "http://purl.org/dc/terms/",
        "conformsTo": "dct:conformsTo",
        "data": { "@id": "cr:data", "@type": "@json" },
        "dataType": { "@id": "cr:dataType", "@type": "@vocab" },
        "examples": { "@id": "cr:examples", "@type": "@json" },
    });
    let plain = [
        "citeAs",
        "column",
        "equivalentProperty",
        "extract",
        "field",
        "fileObject",
        "fileProperty",
        "fileSet",
        "format",
        "includes",
        "isLiveDataset",
        "jsonPath",
        "key",
        "md5",
        "parentField",
        "path",
        "recordSet",
        "references",
        "regex",
        "repeated",
        "replace",
        "samplingRate",
        "separator",
        "source",
        "subField",
        "transform",
    ];
    if let Some(entries) = context.as_object_mut() {
        entries.extend(plain.map(|name| (name.to_owned(), Value::from(format!("cr:{name}")))));
    }
    context
}
