//! Anchored vertices of deformable solids: fixed parts and parts with prescribed motion.

use crate::build::shapes::shape;
use crate::error::SceneError;
use crate::file::{Domain, Moved, Scene, Solid as SolidSpec, Wall, vector};
use meniscus_elastic::{Anchor, AnchorMotion};
use meniscus_numerics::Vector;
use meniscus_numerics::mesh::VolumeMesh;

/// Largest distance outside a region, in mesh edges, of an anchored vertex. It includes vertices on the region's surface.
const ANCHOR_TOLERANCE_EDGES: f64 = 1e-6;

/// The anchored vertices of a solid, grouped by region.
///
/// # Errors
/// [`SceneError`] for a region without vertices, for overlapping regions with different motions, and for a part that would
/// leave the domain through a closed side. `at` marks the error with the region's key.
pub fn anchors<const D: usize>(
    mesh: &VolumeMesh<D>,
    scene: &Scene,
    spec: &SolidSpec,
    at: &dyn Fn(&str, SceneError) -> SceneError,
) -> Result<Vec<Anchor<D>>, SceneError> {
    let fixed = spec.fixed.iter().enumerate().map(|(k, s)| (format!("fixed.{k}"), s, AnchorMotion::Fixed));
    let moved = spec.moved.iter().enumerate();
    let moved = moved.map(|(k, m)| (format!("moved.{k}.shape"), &m.shape, prescribed_motion(m)));
    let mut anchor_of_vertex: Vec<Option<usize>> = vec![None; mesh.positions.len()];
    let mut anchors: Vec<Anchor<D>> = Vec::new();
    for (key, region, motion) in fixed.chain(moved) {
        let region = shape::<D>(region, &scene.files).map_err(|e| at(&key, e))?;
        let inside =
            Anchor::within(mesh, |x| region.signed_distance(x) <= ANCHOR_TOLERANCE_EDGES * spec.mesh_edge);
        let refuse = |message: &str, help: &str| Err(at(&key, SceneError::new(message).with_help(help)));
        if inside.vertices.is_empty() {
            let message = format!("this region contains no vertex of the solid `{}`", spec.name);
            return refuse(&message, "enlarge it, or move it onto the solid");
        }
        let holder = |v: &u32| anchor_of_vertex[*v as usize].map(|k| &anchors[k].motion);
        let conflicting =
            inside.vertices.iter().filter(|v| holder(v).is_some_and(|other| *other != motion)).count();
        if conflicting > 0 {
            let message = format!(
                "{conflicting} vertices of this region belong to an earlier region of `fixed` or `moved` with another motion"
            );
            return refuse(&message, "regions with different motions must not overlap");
        }
        let vertices: Vec<u32> =
            inside.vertices.into_iter().filter(|v| anchor_of_vertex[*v as usize].is_none()).collect();
        if vertices.is_empty() {
            return refuse(
                "all vertices of this region belong to earlier regions of `fixed` or `moved`",
                "remove this region, or enlarge it",
            );
        }
        if let Some(time) = domain_exit_time(mesh, &vertices, &motion, &scene.domain, scene.output.duration) {
            let message = format!("this region has left the domain through a closed side at {time} s");
            return refuse(
                &message,
                "reduce its velocity or displacement, shorten the run, or open the side (`domain.walls`)",
            );
        }
        vertices.iter().for_each(|v| anchor_of_vertex[*v as usize] = Some(anchors.len()));
        anchors.push(Anchor { vertices, motion });
    }
    Ok(anchors)
}

/// The first time, s, at which a vertex that starts inside the domain lies beyond a closed side. Only the times of keyframes
/// and the end of the run are checked, since motion between them is linear.
fn domain_exit_time<const D: usize>(
    mesh: &VolumeMesh<D>,
    vertices: &[u32],
    motion: &AnchorMotion<D>,
    domain: &Domain,
    duration: f64,
) -> Option<f64> {
    let breakpoints = match motion {
        AnchorMotion::Fixed => return None,
        AnchorMotion::Velocity(_) => Vec::new(),
        AnchorMotion::Keyframes(keys) => {
            keys.iter().map(|k| k.0).filter(|t| (0.0..duration).contains(t)).collect()
        }
    };
    let beyond = |x: &Vector<D>| {
        let past = |a: usize| [x[a] < 0.0, x[a] > domain.size[a]];
        (0..D).any(|a| past(a).iter().zip(domain.walls[a]).any(|(past, wall)| *past && wall != Wall::Open))
    };
    breakpoints.into_iter().chain([duration]).find(|time| {
        let displacement = motion.displacement(*time);
        vertices
            .iter()
            .map(|v| mesh.positions[*v as usize])
            .any(|x| !beyond(&x) && beyond(&(x + displacement)))
    })
}

/// The prescribed motion of a part.
fn prescribed_motion<const D: usize>(moved: &Moved) -> AnchorMotion<D> {
    match moved.keyframes.is_empty() {
        true => AnchorMotion::Velocity(vector(&moved.velocity)),
        false => {
            AnchorMotion::Keyframes(moved.keyframes.iter().map(|k| (k.time, vector(&k.translate))).collect())
        }
    }
}
