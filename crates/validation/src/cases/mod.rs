//! The cases, one file each.

use crate::Case;

/// All cases, in the order of the table.
pub fn all() -> &'static [Case] {
    &[]
}
