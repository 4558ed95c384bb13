//! The cases by subject, one file per family.

mod elastic;
mod liquid;
mod rigid;
mod soft;
mod solver;
mod wetting;

use crate::Case;

/// All cases, in the order of the table.
pub fn all() -> &'static [Case] {
    &ALL
}

const ALL: [Case; 67] = [
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
    wetting::sessile::CASE_2D,
    wetting::sessile::CASE_3D,
    wetting::sessile::CURVED,
    wetting::sessile::STEPS,
    wetting::sessile::THIN,
    rigid::bounce::CASE,
    rigid::moving_plate::CASE,
    wetting::sliding::CASE,
    wetting::wettability_step::CASE,
    wetting::hysteresis::CASE,
    wetting::line_friction::CASE,
    wetting::sessile_gravity::CASE_2D,
    wetting::sessile_gravity::CASE_3D,
    wetting::meniscus::CASE_2D,
    wetting::meniscus::TUBE,
    wetting::domain_walls::CASE,
    rigid::floating::FREE_BODY,
    rigid::floating::FIXED_BODY,
    soft::floating_plate::CASE,
    rigid::buoyancy::BUOYANCY,
    rigid::buoyancy::ADDED_MASS,
    solver::surface_distance::DISTANCE,
    solver::surface_distance::LENGTH,
    liquid::volume::CASE,
    liquid::momentum::CASE,
    rigid::momentum_with_solid::CASE,
    rigid::leak::CASE,
    elastic::beam::BEAM,
    elastic::unstructured::CASE,
    elastic::turek_hron::FLAG,
    soft::plates::KINK,
    soft::plates::STRIP,
    soft::plates::STIFF,
    wetting::ridge::CASE,
    soft::soft_sag::CASE,
    soft::soft_moment::CASE,
    soft::edge_pinned::CASE,
    soft::soft_tank::CASE,
    soft::soft_release::CASE,
    soft::newton::CASE,
    elastic::soft_stack::CASE,
    elastic::soft_slope::CASE,
    elastic::soft_energy::CASE,
    elastic::hertz::CASE,
    elastic::extreme_deformation::CASE,
    rigid::rigid_contact::CASE,
    soft::soft_impact::CASE,
    soft::elastica_drop::CASE,
    wetting::wrapping::OPEN,
    wetting::wrapping::WRAP,
    solver::pressure_matrix::CASE,
    solver::pressure_iterations::CASE,
    solver::pressure_iterations_soft::CASE,
];
