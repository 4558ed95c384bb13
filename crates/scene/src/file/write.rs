//! Writes a resolved scene as a scene file.

use crate::error::{ErrorKind, SceneError};
use crate::file::grammar::{
    Acceleration, Angle, AngleAtFile, AxisAngleFile, BallFile, BodyFile, BoxFile, CapsuleFile, CollisionFile,
    ContactAngleFile, ContactLineFile, CowFile, CylinderFile, DeflectionFile, Density, DifferenceFile,
    DomainFile, DropsFile, DynamicViscosity, Either, EllipsoidFile, ExpectFile, ExtrusionFile, Frequency,
    FrequencyFile, GradientFile, HalfSpaceFile, HysteresisFile, KeyframeFile, KinematicViscosity, Length,
    LiquidFile, MaxFile, MaxSpeedFile, MeshFile, MeshScale, MovedFile, Named, NumericsFile, OutputFile,
    PatchFile, PeriodFile, PerturbedBallFile, PositionFile, ReachFile, RotationFile, SceneFile, ShapeFile,
    SmoothUnionFile, SolidFile, SolidMeshFile, SolidTensionFile, Speed, Tension, TensionFile, Time,
    WallsFile, WaveFile, WettedFile, WettingImageFile,
};
use crate::file::resolved::{
    Body, ContactLine, Domain, Expectation, Hysteresis, Moved, Numerics, Outline, Rotation, Scene, ShapeSpec,
    Solid, SolidTension, Tensions, Wetting, WettingImage,
};

impl Scene {
    /// The scene as run: SI, defaults and overrides filled in. Reading it again gives an identical scene.
    ///
    /// # Errors
    /// [`SceneError`] if the text cannot be written; this does not happen for a valid scene.
    pub fn to_toml(&self) -> Result<String, SceneError> {
        let body = toml::to_string(&self.to_file()).map_err(|e| SceneError {
            kind: ErrorKind::Io,
            ..SceneError::new(format!("the scene cannot be written: {e}"))
        })?;
        Ok(format!("# As run: every default and override filled in, SI units.\n{body}"))
    }

    /// The scene in the grammar of a scene file.
    pub fn to_file(&self) -> SceneFile {
        SceneFile {
            format: 1,
            name: self.name.clone(),
            based_on: self.based_on.clone(),
            description: self.description.clone(),
            cost: self.cost.clone(),
            domain: domain(&self.domain),
            liquid: LiquidFile {
                density: Density(self.liquid.density),
                kinematic_viscosity: Some(KinematicViscosity(self.liquid.kinematic_viscosity)),
                dynamic_viscosity: None,
                gravity: Some(self.liquid.gravity.iter().map(|&g| Acceleration(g)).collect()),
                body: self.liquid.bodies.iter().map(body).collect(),
            },
            solid: self.solids.iter().map(solid).collect(),
            tension: tension(&self.tension),
            contact_line: Some(contact_line(&self.contact_line)),
            numerics: numerics(&self.numerics),
            output: OutputFile {
                duration: Time(self.output.duration),
                frame_interval: Some(Time(self.output.frame_interval)),
                formats: Some(self.output.formats.clone()),
                checkpoint_every: u32::try_from(self.output.checkpoint_every).ok(),
            },
            expect: Some(expect(&self.expect)),
        }
    }
}

fn lengths(v: &[f64]) -> Vec<Length> {
    v.iter().map(|&x| Length::metres(x)).collect()
}

fn speeds(v: &[f64]) -> Vec<Speed> {
    v.iter().map(|&x| Speed(x)).collect()
}

fn to_u32(n: usize) -> Option<u32> {
    u32::try_from(n).ok()
}

fn domain(d: &Domain) -> DomainFile {
    let last = d.dimension - 1;
    let is_3d = d.dimension == 3;
    DomainFile {
        dimension: d.dimension as u32,
        size: lengths(&d.size),
        resolution: d.cells.iter().max().and_then(|&n| to_u32(n)),
        dx: None,
        quality: None,
        walls: WallsFile {
            all: None,
            left: Some(d.walls[0][0]),
            right: Some(d.walls[0][1]),
            front: is_3d.then(|| d.walls[1][0]),
            back: is_3d.then(|| d.walls[1][1]),
            bottom: Some(d.walls[last][0]),
            top: Some(d.walls[last][1]),
        },
        wall_contact_angle: Some(Angle(d.wall_contact_angle)),
    }
}

fn body(b: &Body) -> BodyFile {
    let displaced = b.displaced.then_some(true);
    BodyFile { shape: shape(&b.shape), velocity: Some(speeds(&b.velocity)), displaced }
}

/// The rotation in the form of the number of dimensions; `None` for the identity.
fn rotation(r: &Rotation, dim: usize) -> Option<RotationFile> {
    if *r == Rotation::NONE {
        None
    } else if dim == 2 {
        Some(Either::Text(Angle(r.angle)))
    } else {
        Some(Either::Rich(AxisAngleFile { axis: r.axis.to_vec(), angle: Angle(r.angle) }))
    }
}

fn shape(s: &ShapeSpec) -> ShapeFile {
    let m = Length::metres;
    match s {
        ShapeSpec::Ball { center, radius } => {
            ShapeFile::Ball(BallFile { center: lengths(center), radius: m(*radius) })
        }
        ShapeSpec::Box { center, half_size, rotation: r } => ShapeFile::Box(BoxFile {
            center: Some(lengths(center)),
            size: Some(half_size.iter().map(|h| m(2.0 * h)).collect()),
            rotation: rotation(r, center.len()),
            ..BoxFile::default()
        }),
        ShapeSpec::HalfSpace { point, normal } => {
            ShapeFile::HalfSpace(HalfSpaceFile { point: lengths(point), normal: normal.clone() })
        }
        ShapeSpec::Cylinder { center, axis, radius, height } => ShapeFile::Cylinder(CylinderFile {
            center: lengths(center),
            axis: axis.clone(),
            radius: m(*radius),
            height: m(*height),
        }),
        ShapeSpec::Capsule { a, b, radius } => {
            ShapeFile::Capsule(CapsuleFile { a: lengths(a), b: lengths(b), radius: m(*radius) })
        }
        ShapeSpec::Ellipsoid { center, radii, rotation: r } => ShapeFile::Ellipsoid(EllipsoidFile {
            center: lengths(center),
            radii: lengths(radii),
            rotation: rotation(r, center.len()),
        }),
        ShapeSpec::PerturbedBall { center, radius, mode, amplitude } => {
            ShapeFile::PerturbedBall(PerturbedBallFile {
                center: lengths(center),
                radius: m(*radius),
                mode: *mode,
                amplitude: *amplitude,
            })
        }
        ShapeSpec::Wave { level, amplitude, wavelength, phase } => ShapeFile::Wave(WaveFile {
            level: m(*level),
            amplitude: m(*amplitude),
            wavelength: m(*wavelength),
            phase: Some(Angle(*phase)),
        }),
        ShapeSpec::Union(list) => ShapeFile::Union(list.iter().map(shape).collect()),
        ShapeSpec::Difference { of, minus } => {
            ShapeFile::Difference(DifferenceFile { of: Box::new(shape(of)), minus: Box::new(shape(minus)) })
        }
        ShapeSpec::SmoothUnion { parts, width } => ShapeFile::SmoothUnion(SmoothUnionFile {
            parts: parts.iter().map(shape).collect(),
            width: m(*width),
        }),
        ShapeSpec::Cow { at, length, rotation: r } => {
            ShapeFile::Cow(CowFile { at: lengths(at), length: m(*length), rotation: rotation(r, at.len()) })
        }
        ShapeSpec::Extrusion { .. } | ShapeSpec::Mesh { .. } => outlined(s),
    }
}

/// Shapes defined by an outline or a file.
fn outlined(s: &ShapeSpec) -> ShapeFile {
    match s {
        ShapeSpec::Extrusion { outline, thickness, center, rotation: r } => {
            let (outline, size) = match outline {
                Outline::Named(name, size) => (Either::Text(*name), Some(Length::metres(*size))),
                Outline::Points(p) => (Either::Rich(p.iter().map(|q| lengths(q)).collect()), None),
            };
            ShapeFile::Extrusion(ExtrusionFile {
                outline,
                size,
                thickness: Length::metres(*thickness),
                center: lengths(center),
                rotation: rotation(r, 3),
            })
        }
        ShapeSpec::Mesh { path, scale, translate, rotation: r } => ShapeFile::Mesh(MeshFile {
            file: path.display().to_string(),
            scale: Some(MeshScale(*scale)),
            translate: Some(lengths(translate)),
            rotation: rotation(r, translate.len()),
        }),
        other => shape(other),
    }
}

fn solid(s: &Solid) -> SolidFile {
    SolidFile {
        name: s.name.clone(),
        density: s.density.map(Density),
        shape: shape(&s.shape),
        mesh: s.shape.volume_file().is_none().then(|| edge(s.mesh_edge)),
        material: s.material.to_file(),
        velocity: Some(speeds(&s.velocity)),
        collision: Some(CollisionFile { restitution: Some(s.restitution), friction: Some(s.friction) }),
        fixed: s.fixed.iter().map(shape).collect(),
        moved: s.moved.iter().map(moved).collect(),
    }
}

fn edge(length: f64) -> SolidMeshFile {
    SolidMeshFile { edge: Some(Length::metres(length)) }
}

fn moved(m: &Moved) -> MovedFile {
    let has_velocity = m.keyframes.is_empty();
    MovedFile {
        shape: shape(&m.shape),
        velocity: has_velocity.then(|| speeds(&m.velocity)),
        keyframes: (!has_velocity).then(|| KeyframeFile::list(&m.keyframes)),
    }
}

fn tension(t: &Tensions) -> TensionFile {
    let solids = t.solids.iter().map(|(n, s)| (n.clone(), wetting(s))).collect();
    TensionFile { liquid_air: Tension(t.liquid_air), solids }
}

fn wetting(w: &Wetting) -> SolidTensionFile {
    let at = |(point, angle): &(Vec<f64>, f64)| AngleAtFile {
        point: lengths(point),
        contact_angle: Angle(*angle),
    };
    let image = |i: &WettingImage| WettingImageFile {
        file: i.path.display().to_string(),
        lower: lengths(&i.lower),
        upper: lengths(&i.upper),
        black: Angle(i.black),
        white: Angle(i.white),
    };
    let patch = |(of, angle): &(ShapeSpec, f64)| PatchFile { shape: shape(of), contact_angle: Angle(*angle) };
    let mut file = SolidTensionFile {
        image: w.image.as_ref().map(image),
        patches: w.patches.iter().map(patch).collect(),
        ..SolidTensionFile::default()
    };
    match &w.tension {
        SolidTension::Energies { liquid_solid, solid_air } => {
            file.liquid_solid = Some(Tension(*liquid_solid));
            file.solid_air = Some(Tension(*solid_air));
        }
        SolidTension::Angle(a) => file.contact_angle = Some(Angle(*a)),
        SolidTension::Gradient { from, to } => {
            file.gradient = Some(GradientFile { from: at(from), to: at(to) });
        }
    }
    file
}

fn hysteresis(h: &Hysteresis) -> HysteresisFile {
    let none = HysteresisFile::default();
    match *h {
        Hysteresis::Between { advancing, receding } => {
            HysteresisFile { advancing: Some(Angle(advancing)), receding: Some(Angle(receding)), ..none }
        }
        Hysteresis::Around { above, below } => {
            HysteresisFile { above: Some(Angle(above)), below: Some(Angle(below)), ..none }
        }
    }
}

fn contact_line(c: &ContactLine) -> ContactLineFile {
    let friction = if c.friction_of.is_empty() {
        Either::Text(DynamicViscosity(c.friction))
    } else {
        Either::Rich(Named(c.friction_of.iter().map(|(n, f)| (n.clone(), DynamicViscosity(*f))).collect()))
    };
    ContactLineFile {
        enabled: Some(c.enabled),
        radius: c.radius.map(Length::metres),
        neumann: c.neumann.then_some(true),
        friction: Some(friction),
        hysteresis: c.hysteresis.as_ref().map(hysteresis),
    }
}

fn numerics(n: &Numerics) -> NumericsFile {
    NumericsFile {
        scheme: Some(n.scheme),
        cfl: Some(n.cfl),
        max_step: n.max_step.is_finite().then_some(Time(n.max_step)),
        tolerance: Some(n.tolerance),
        max_iterations: to_u32(n.max_iterations),
        capillary_step: Some(n.capillary_step),
        newton_iterations: (n.newton_iterations > 0).then_some(n.newton_iterations),
        fixed_step: n.fixed_step.map(Time),
        restore_momentum: Some(n.restore_momentum),
        threads: n.threads.and_then(to_u32),
    }
}

fn expect(list: &[Expectation]) -> ExpectFile {
    let mut e = ExpectFile::default();
    for item in list {
        match item {
            Expectation::VolumeDrift { max } => e.volume_drift = Some(MaxFile { max: *max }),
            Expectation::MomentumError { max } => e.momentum_error = Some(MaxFile { max: *max }),
            Expectation::EnergyGrowth { max } => e.energy_growth = Some(MaxFile { max: *max }),
            Expectation::Repair { name, max } => e.repairs.get_or_insert_default().set(name, *max),
            Expectation::MaxSpeed { max } => e.max_speed = Some(MaxSpeedFile { max: Speed(*max) }),
            Expectation::Period { mode, value, tolerance } => {
                e.period = Some(PeriodFile { mode: *mode, value: Time(*value), tolerance: *tolerance });
            }
            Expectation::Frequency { mode, value, tolerance } => {
                let value = Frequency(*value);
                e.frequency = Some(FrequencyFile { mode: *mode, value, tolerance: *tolerance });
            }
            Expectation::ContactAngle { solid, value, tolerance } => e.contact_angle.push(ContactAngleFile {
                solid: solid.clone(),
                value: Some(Angle(*value)),
                tolerance: Angle(*tolerance),
            }),
            Expectation::Drops { min, max } => {
                let max = (*max < u32::MAX).then_some(*max);
                e.drops = Some(DropsFile { count: None, min: Some(*min), max });
            }
            Expectation::Reach { side, value, tolerance } => e.reach.push(ReachFile {
                side: *side,
                value: Length::metres(*value),
                tolerance: Length::metres(*tolerance),
            }),
            Expectation::Floats { solid } => e.floats.push(solid.clone()),
            Expectation::Sinks { solid } => e.sinks.push(solid.clone()),
            Expectation::Wetted { solid, min, max } => {
                e.wetted.push(WettedFile { solid: solid.clone(), min: Some(*min), max: Some(*max) });
            }
            Expectation::Deflection { solid, min, max } => e.deflection.push(DeflectionFile {
                solid: solid.clone(),
                min: Some(Length::metres(*min)),
                max: max.is_finite().then(|| Length::metres(*max)),
            }),
            Expectation::Position { solid, value, tolerance, along } => e.position.push(PositionFile {
                solid: solid.clone(),
                value: value.iter().map(|&x| Length::metres(x)).collect(),
                tolerance: Length::metres(*tolerance),
                along: along.clone(),
            }),
        }
    }
    e
}
