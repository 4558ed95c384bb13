//! The sections of a scene. Each is one type, as it is written and as it is used, with numbers in SI units.
//!
//! `validate` checks a section in place and makes defaults explicit that depend on other keys.

/// Makes the text of a type that enters the identity of a scene: the names and values that are listed, in this order.
macro_rules! identity_text {
    ($type:ident, $of:ident => $($name:ident: $value:expr),*) => {
        impl std::fmt::Debug for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                let $of = self;
                f.debug_struct(stringify!($type))$(.field(stringify!($name), &$value))*.finish()
            }
        }
    };
}

mod contact_line;
mod domain;
mod expect;
mod keyframe;
mod liquid;
mod material;
mod numerics;
mod output;
mod solid;
mod wetting;

pub use contact_line::{ContactLine, Hysteresis};
pub use domain::{Domain, Quality, Wall};
pub(super) use expect::Names;
pub(crate) use expect::entry as expect_entry;
pub use expect::{Deflection, Expect, SeriesBound, SeriesValue, Side, Wetted};
pub use keyframe::Keyframe;
pub use liquid::{Body, Liquid};
pub use material::{Elastic, Material};
pub use numerics::{Numerics, Scheme};
pub use output::Output;
pub use solid::{Collision, Moved, Solid};
pub use wetting::{AngleAt, Patch, SolidTension, Tensions, WALLS, Wetting, WettingImage};

/// Whether a key with the default `false` can be left out.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_false(value: &bool) -> bool {
    !*value
}

/// Whether a key with the default 0 can be left out.
fn is_zero<N: Default + PartialEq>(value: &N) -> bool {
    *value == N::default()
}
