//! Reflection and refraction of a ray at the surface of the liquid.

use super::geometry::Hit;
use crate::folder::V3;

/// Refractive index of the liquid.
const REFRACTIVE_INDEX: f64 = 1.33;

/// Reflected and refracted ray at a point of the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FresnelSplit {
    /// Fresnel reflectance, unpolarised.
    pub reflectance: f64,
    pub reflected: V3,
    /// `None` for total internal reflection.
    pub refracted: Option<V3>,
    /// Whether the ray comes from outside.
    pub entering: bool,
}

impl FresnelSplit {
    /// The split for a ray in direction `d`. A wetted facet transmits it unchanged.
    pub(crate) fn new(d: &V3, hit: &Hit) -> Self {
        let entering = d.dot(&hit.geometric_normal) < 0.0;
        if hit.wetted {
            return Self { reflectance: 0.0, reflected: *d, refracted: Some(*d), entering };
        }
        let sign = if entering { 1.0 } else { -1.0 };
        let facet = hit.geometric_normal * sign;
        let normal = facing(&(hit.shading_normal * sign), &facet, d);
        let eta = if entering { 1.0 / REFRACTIVE_INDEX } else { REFRACTIVE_INDEX };
        let cos = (-d.dot(&normal)).clamp(0.0, 1.0);
        let reflected = above(d + normal * (2.0 * cos), &facet);
        let sin2 = eta * eta * (1.0 - cos * cos);
        if sin2 >= 1.0 {
            return Self { reflectance: 1.0, reflected, refracted: None, entering };
        }
        let inner = (1.0 - sin2).sqrt();
        let refracted = above(d * eta + normal * (eta * cos - inner), &-facet);
        let rs = (eta * cos - inner) / (eta * cos + inner);
        let rp = (cos - eta * inner) / (cos + eta * inner);
        Self { reflectance: 0.5 * (rs * rs + rp * rp), reflected, refracted: Some(refracted), entering }
    }
}

/// The interpolated normal, turned towards the facet's normal so far that the ray arrives from its front.
fn facing(smooth: &V3, facet: &V3, d: &V3) -> V3 {
    const LEAST: f64 = 0.02;
    let front = -d.dot(smooth);
    if front >= LEAST {
        return *smooth;
    }
    let turn = ((LEAST - front) / (-d.dot(facet) - front).max(1e-9)).clamp(0.0, 1.0);
    (smooth * (1.0 - turn) + facet * turn).try_normalize(1e-9).unwrap_or(*facet)
}

/// The direction, corrected to the side of the facet's normal.
fn above(d: V3, facet: &V3) -> V3 {
    const LEAST: f64 = 1e-3;
    let up = d.dot(facet);
    let lifted = if up < LEAST { d + facet * (LEAST - up) } else { d };
    lifted.try_normalize(1e-9).unwrap_or(*facet)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(d: V3) -> FresnelSplit {
        FresnelSplit::new(
            &d,
            &Hit { t: 1.0, geometric_normal: V3::z(), shading_normal: V3::z(), wetted: false, tint: 0.0 },
        )
    }

    #[test]
    fn straight_down_reflects_two_percent() {
        let i = at(-V3::z());
        assert!((i.reflectance - (0.33f64 / 2.33).powi(2)).abs() < 1e-12 && i.entering);
        assert!((i.refracted.unwrap() + V3::z()).norm() < 1e-12);
    }

    #[test]
    fn obeys_snell_and_reflects_all_beyond_the_critical_angle() {
        let (s, c) = 0.6f64.sin_cos();
        let t = at(V3::new(s, 0.0, -c)).refracted.unwrap();
        assert!((t.x * REFRACTIVE_INDEX - s).abs() < 1e-12);
        let (s, c) = 0.9f64.sin_cos();
        let inside = at(V3::new(s, 0.0, c));
        assert!(inside.refracted.is_none() && inside.reflectance == 1.0 && !inside.entering);
        assert!((inside.reflected - V3::new(s, 0.0, -c)).norm() < 1e-12);
    }
}
