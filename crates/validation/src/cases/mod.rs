//! The cases by subject, one file per family.

mod elastic;
pub(crate) mod liquid;
pub mod paper;
pub(crate) mod rigid;
pub(crate) mod soft;
mod solver;
pub(crate) mod wetting;

use crate::{Case, Group};
use std::sync::LazyLock;

/// All cases, group by group.
pub fn all() -> &'static [Case] {
    &ALL
}

/// The groups, in the order in which they run.
pub fn groups() -> &'static [Group] {
    &GROUPS
}

static ALL: LazyLock<Vec<Case>> =
    LazyLock::new(|| GROUPS.iter().flat_map(|group| group.cases).copied().collect());

static GROUPS: [Group; 6] =
    [liquid::GROUP, wetting::GROUP, rigid::GROUP, elastic::GROUP, soft::GROUP, solver::GROUP];
