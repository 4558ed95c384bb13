//! The cases by subject, one file per family.

mod elastic;
mod liquid;
mod rigid;
mod soft;
mod solver;
mod wetting;

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
