//! Possible but unlikely values of a scene: wrong units, a fixture on a hammer's mount, an unusual contact.

use crate::parameter::{Fault, Parameters};

use super::model::{Scene, Supply};

impl Scene {
    /// Remarks on unusual values, by paths in a study. They do not prevent a run.
    pub fn remarks(&self) -> Vec<Fault> {
        let mut remarks = Vec::new();
        self.unusual("", &mut remarks);
        for hammer in &self.hammers {
            let prefix = format!("hammer.{}", hammer.name);
            Supply::of(hammer, &self.environment).unusual(&prefix, &mut remarks);
            hammer.unusual(&prefix, &mut remarks);
            hammer.parameters.unusual(&format!("{prefix}.parameters"), &mut remarks);
            remarks.extend(self.contact_remarks(hammer));
        }
        for casting in &self.castings {
            let prefix = format!("casting.{}", casting.name);
            casting.unusual(&prefix, &mut remarks);
            for fixture in &casting.fixtures {
                let prefix = format!("{prefix}.fixture.{}", fixture.name);
                match &fixture.pad {
                    Some(pad) => pad.unusual(&prefix, &mut remarks),
                    None => fixture.unusual(&prefix, &mut remarks),
                }
                remarks.extend(
                    self.on_a_mount(&fixture.point).map(|message| Fault { path: format!("{prefix}.point"), message }),
                );
            }
        }
        self.environment.unusual("environment", &mut remarks);
        self.solver.unusual("solver", &mut remarks);
        self.outputs.unusual("outputs", &mut remarks);
        remarks
    }

    /// Remark on a fixture on a point that carries a hammer.
    fn on_a_mount(&self, point: &str) -> Option<String> {
        let carries = |(carrier, _): &(String, f64)| carrier == point;
        let hammer = self.hammers.iter().find(|hammer| hammer.mount.points.iter().any(carries))?;
        let name = &hammer.name;
        Some(format!(
            "`{point}` carries hammer `{name}`: a casting usually stands on points of the table, not on a mount"
        ))
    }
}
