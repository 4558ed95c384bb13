//! The cases, one file per family.

mod bounce;
mod buoyancy;
mod capillary_wave;
mod dam_break;
mod edge_pinned;
mod elastic;
mod elastica_drop;
mod floating;
mod floating_plate;
mod hertz;
mod hydrostatic;
mod hysteresis;
mod iterations;
mod iterations_soft;
mod leak;
mod line_friction;
mod meniscus;
mod momentum;
mod momentum_with_solid;
mod moving_drop;
mod moving_plate;
mod newton;
mod open_side;
mod pressure_matrix;
mod rayleigh;
mod rayleigh_plateau;
mod ridge;
mod rigid_contact;
mod sessile;
mod sessile_gravity;
mod sliding;
mod soft;
mod soft_energy;
mod soft_impact;
mod soft_moment;
mod soft_release;
mod soft_sag;
mod soft_slope;
mod soft_stack;
mod soft_tank;
mod static_drop;
mod surface_distance;
mod transport;
mod turek_hron;
mod unstructured;
mod violence;
mod volume;
mod walls;
mod wettability_step;
mod wrapping;

use crate::Case;

/// All cases, in the order of the table.
pub fn all() -> &'static [Case] {
    &ALL
}

const ALL: [Case; 67] = [
    static_drop::PLANE,
    static_drop::SPACE,
    rayleigh::PLANE,
    rayleigh::SPACE,
    rayleigh::STEPS,
    rayleigh::LAMB,
    capillary_wave::CASE,
    moving_drop::CASE,
    rayleigh_plateau::CASE,
    hydrostatic::CASE,
    open_side::CASE,
    transport::ZALESAK,
    transport::VORTEX,
    dam_break::CASE,
    sessile::PLANE,
    sessile::SPACE,
    sessile::CURVED,
    sessile::STEPS,
    sessile::THIN,
    bounce::CASE,
    moving_plate::CASE,
    sliding::CASE,
    wettability_step::CASE,
    hysteresis::CASE,
    line_friction::CASE,
    sessile_gravity::PLANE,
    sessile_gravity::SPACE,
    meniscus::PLANE,
    meniscus::TUBE,
    walls::CASE,
    floating::FREE,
    floating::HELD,
    floating_plate::CASE,
    buoyancy::BUOYANCY,
    buoyancy::ADDED,
    surface_distance::DISTANCE,
    surface_distance::LENGTH,
    volume::CASE,
    momentum::CASE,
    momentum_with_solid::CASE,
    leak::CASE,
    elastic::BEAM,
    unstructured::CASE,
    turek_hron::FLAG,
    soft::KINK,
    soft::STRIP,
    soft::STIFF,
    ridge::CASE,
    soft_sag::CASE,
    soft_moment::CASE,
    edge_pinned::CASE,
    soft_tank::CASE,
    soft_release::CASE,
    newton::CASE,
    soft_stack::CASE,
    soft_slope::CASE,
    soft_energy::CASE,
    hertz::CASE,
    violence::CASE,
    rigid_contact::CASE,
    soft_impact::CASE,
    elastica_drop::CASE,
    wrapping::OPEN,
    wrapping::WRAP,
    pressure_matrix::CASE,
    iterations::CASE,
    iterations_soft::CASE,
];
