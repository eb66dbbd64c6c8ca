//! The built-in machine.

use super::formats::parse_matrix_market;
use crate::structure::error::StructureError;
use crate::structure::label::regular_labels;
use crate::structure::matrices::ModelMatrices;
use crate::structure::model::{FeModel, Sources};
use crate::structure::points::InterfacePoints;

const MASS: &[u8] = include_bytes!("../../../assets/station/M_bare.mtx.gz");
const STIFFNESS: &[u8] = include_bytes!("../../../assets/station/K.mtx.gz");
const POINTS: &str = include_str!("../../../assets/station/interface_points.csv");

impl FeModel {
    /// The hammer station that comes with the program: 546 DOF, 2176 kg without hammers, see `src/assets/station`.
    ///
    /// # Errors
    /// None with the data as shipped.
    pub fn station() -> Result<Self, StructureError> {
        let sources = Sources {
            mass: "station/M_bare.mtx.gz".to_owned(),
            stiffness: "station/K.mtx.gz".to_owned(),
            damping: String::new(),
            labels: String::new(),
            points: "station/interface_points.csv".to_owned(),
        };
        let mass = parse_matrix_market(&sources.mass, MASS)?;
        let stiffness = parse_matrix_market(&sources.stiffness, STIFFNESS)?;
        let labels = regular_labels(mass.rows(), 6);
        let points = InterfacePoints::parse(&sources.points, POINTS)?;
        Self::validated(ModelMatrices { mass, stiffness, damping: None, labels }, points, &sources)
    }
}
