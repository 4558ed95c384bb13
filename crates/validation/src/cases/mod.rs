//! The cases by subject, one file per family.

mod elastic;
mod liquid;
mod rigid;
mod soft;
mod solver;
mod wetting;

use crate::Case;
use std::sync::LazyLock;

/// Cases about one subject.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// The subject.
    pub title: &'static str,
    /// Its cases.
    pub cases: &'static [Case],
}

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

static GROUPS: [Group; 6] = [
    Group {
        title: "Liquid without solids",
        cases: &[
            liquid::static_drop::CASE_2D,
            liquid::static_drop::CASE_3D,
            liquid::rayleigh::CASE_2D,
            liquid::rayleigh::CASE_3D,
            liquid::rayleigh::STEPS,
            liquid::rayleigh::LAMB,
            liquid::capillary_wave::CASE,
            liquid::moving_drop::CASE,
            liquid::rayleigh_plateau::CASE,
            liquid::hydrostatic::CASE,
            liquid::open_side::CASE,
            liquid::transport::ZALESAK,
            liquid::transport::VORTEX,
            liquid::dam_break::CASE,
            liquid::volume::CASE,
            liquid::momentum::CASE,
        ],
    },
    Group {
        title: "Contact lines",
        cases: &[
            wetting::sessile::CASE_2D,
            wetting::sessile::CASE_3D,
            wetting::sessile::CURVED,
            wetting::sessile::STEPS,
            wetting::sessile::THIN,
            wetting::sliding::CASE,
            wetting::wettability_step::CASE,
            wetting::hysteresis::CASE,
            wetting::line_friction::CASE,
            wetting::sessile_gravity::CASE_2D,
            wetting::sessile_gravity::CASE_3D,
            wetting::meniscus::CASE_2D,
            wetting::meniscus::TUBE,
            wetting::domain_walls::CASE,
            wetting::ridge::CASE,
            wetting::wrapping::OPEN,
            wetting::wrapping::WRAP,
        ],
    },
    Group {
        title: "Rigid solids",
        cases: &[
            rigid::bounce::CASE,
            rigid::moving_plate::CASE,
            rigid::floating::FREE_BODY,
            rigid::floating::FIXED_BODY,
            rigid::buoyancy::BUOYANCY,
            rigid::buoyancy::ADDED_MASS,
            rigid::momentum_with_solid::CASE,
            rigid::leak::CASE,
            rigid::rigid_contact::CASE,
        ],
    },
    Group {
        title: "Deformable solids without liquid",
        cases: &[
            elastic::beam::BEAM,
            elastic::unstructured::CASE,
            elastic::turek_hron::FLAG,
            elastic::soft_stack::CASE,
            elastic::soft_slope::CASE,
            elastic::soft_energy::CASE,
            elastic::hertz::CASE,
            elastic::extreme_deformation::CASE,
        ],
    },
    Group {
        title: "Liquid and deformable solids",
        cases: &[
            soft::floating_plate::CASE,
            soft::plates::KINK,
            soft::plates::STRIP,
            soft::plates::STIFF,
            soft::soft_sag::CASE,
            soft::soft_moment::CASE,
            soft::edge_pinned::CASE,
            soft::soft_tank::CASE,
            soft::soft_tension::CASE,
            soft::soft_release::CASE,
            soft::newton::CASE,
            soft::soft_impact::CASE,
            soft::elastica_drop::CASE,
        ],
    },
    Group {
        title: "Solvers and geometry",
        cases: &[
            solver::surface_distance::DISTANCE,
            solver::surface_distance::LENGTH,
            solver::pressure_matrix::CASE,
            solver::pressure_iterations::CASE,
            solver::pressure_iterations_soft::CASE,
        ],
    },
];
