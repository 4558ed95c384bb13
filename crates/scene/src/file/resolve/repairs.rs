//! Resolves bounds of repairs.

use super::resolver::Resolver;
use crate::error::SceneError;
use crate::file::grammar::{ExpectFile, RepairsFile};
use crate::file::resolved::Expectation;

impl Resolver {
    /// Appends the bounds of repairs to `out`.
    pub fn expect_repairs(&self, e: &ExpectFile, out: &mut Vec<Expectation>) -> Result<(), SceneError> {
        for (name, max) in e.repairs.iter().flat_map(RepairsFile::bounds) {
            let max = self.not_negative(&format!("expect.repairs.{name}"), "a bound", max)?;
            out.push(Expectation::Repair { name: name.to_string(), max });
        }
        Ok(())
    }
}
