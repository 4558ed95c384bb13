//! Pictures and pages of made-up runs.

use std::path::PathBuf;

use crate::common::{self, Sample};
use meniscus_numerics::mesh::ply::PlyMesh;
use meniscus_view::{
    Camera, ColorBy, PageOptions, RenderOptions, Renderer, RunFolder, Style, make_page, render,
};

fn folder(name: &str, sample: Sample, frames: u32) -> PathBuf {
    let dir = std::env::temp_dir().join(format!("meniscus-view-{name}-{}", std::process::id()));
    common::write(&dir, sample, frames);
    dir
}

fn small() -> RenderOptions {
    RenderOptions { size: (96, 64).into(), film: false, ..RenderOptions::default() }
}

#[test]
fn pictures_do_not_depend_on_the_number_of_threads() {
    let dir = folder("threads", Sample::Drop, 1);
    let picture = |threads: usize, style: Style| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let options = RenderOptions { style: Some(style), ..small() };
        pool.install(|| Renderer::open(&dir, &options).unwrap().image(0).unwrap())
    };
    for style in [Style::Glass, Style::Matte] {
        assert_eq!(picture(1, style), picture(2, style));
        assert_eq!(picture(2, style), picture(3, style));
    }
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn the_drop_stands_out_and_no_pixel_is_black() {
    let dir = folder("visible", Sample::Ball, 1);
    let options = RenderOptions { size: (160, 90).into(), ..small() };
    let image = Renderer::open(&dir, &options).unwrap().image(0).unwrap();
    let pixel = |x: usize, y: usize| &image.rgb[3 * (y * 160 + x)..][..3];
    let bluish =
        (0..160 * 90).filter(|i| pixel(i % 160, i / 160)[2] > pixel(i % 160, i / 160)[0] + 25).count();
    assert!(bluish > 400, "{bluish}");
    let dark = image.rgb.chunks(3).filter(|p| p.iter().all(|c| *c < 25)).count();
    assert_eq!(dark, 0);
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn files_are_written_for_the_wanted_frames() {
    let dir = folder("frames", Sample::Flat, 6);
    let options = RenderOptions { frames: Some(1..=5), every: 2, ..small() };
    let mut told = Vec::new();
    let made = render(&dir, &options, |done, all| told.push((done, all))).unwrap();
    let names: Vec<_> = made.images.iter().map(|p| p.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(names, ["frame_0001.png", "frame_0003.png", "frame_0005.png"]);
    assert_eq!(told, [(1, 3), (2, 3), (3, 3)]);
    let file = std::io::BufReader::new(std::fs::File::open(&made.images[0]).unwrap());
    let reader = png::Decoder::new(file).read_info().unwrap();
    assert_eq!((reader.info().width, reader.info().height), (96, 64));
    let shaded = RenderOptions { shade: ColorBy::Strain, ..small() };
    let missing = render(&dir, &shaded, |_, _| ()).unwrap_err().to_string();
    assert!(missing.contains("no solid in the frames has values of `strain`"), "{missing}");
    let none = RenderOptions { frames: Some(70..=80), ..small() };
    assert!(render(&dir, &none, |_, _| ()).is_err());
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn pictures_of_an_earlier_call_do_not_stay() {
    let dir = folder("stale", Sample::Flat, 4);
    assert_eq!(render(&dir, &small(), |_, _| ()).unwrap().images.len(), 4);
    std::fs::write(dir.join("render/mine.png"), "").unwrap();
    let fewer = RenderOptions { every: 3, size: (48, 32).into(), ..small() };
    let made = render(&dir, &fewer, |_, _| ()).unwrap();
    assert_eq!((made.images.len(), made.frames, made.removed), (2, 4, 2));
    let left = |to: &str| {
        let mut names: Vec<_> = (std::fs::read_dir(dir.join(to)).unwrap())
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    assert_eq!(left("render"), ["frame_0000.png", "frame_0003.png", "mine.png"]);
    // A folder that was asked for may hold what is not ours: nothing is removed from it.
    let other = RenderOptions { frames: Some(1..=1), to: Some(dir.join("render")), ..small() };
    assert!(render(&dir, &other, |_, _| ()).unwrap_err().to_string().contains("would not overwrite"));
    assert_eq!(left("render").len(), 3);
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn cameras_that_show_nothing_are_refused() {
    let dir = folder("camera-2d", Sample::Flat, 1);
    let camera = |distance| RenderOptions {
        camera: Some(Camera { distance: Some(distance), ..Camera::default() }),
        ..small()
    };
    let error = Renderer::open(&dir, &camera(0.3)).unwrap_err().to_string();
    assert!(error.contains("a camera is for 3D"), "{error}");
    std::fs::remove_dir_all(dir).unwrap();
    let dir = folder("camera-3d", Sample::Drop, 1);
    let filled = |distance| render(&dir, &camera(distance), |_, _| ()).map(|made| made.filled_share);
    let (near, far) = (filled(0.3).unwrap(), filled(30.0).unwrap());
    assert!(near > 0.1 && far < 0.01, "{near} {far}");
    // The same from a target beside the drop, and from one that leaves it out of the picture.
    let beside = |x: f64| {
        let mut options = camera(0.3);
        options.camera = options.camera.map(|c| Camera { target: Some([x, 0.05, 0.03]), ..c });
        render(&dir, &options, |_, _| ()).map(|made| made.filled_share)
    };
    assert!(beside(0.05).unwrap() > 0.1);
    assert!(beside(5.0).unwrap_err().to_string().contains("would be empty"));
    // What is dressed down has no floor, no lines, and the background that was asked for.
    let mut plain = RenderOptions { samples: 1, ..small() };
    plain.appearance.floor = false;
    (plain.appearance.domain, plain.appearance.line, plain.appearance.background) =
        (false, false, Some(0x80_40_20));
    let image = Renderer::open(&dir, &plain).unwrap().image(0).unwrap();
    assert_eq!((&image.rgb[..3], red(&image)), (&[0x80, 0x40, 0x20][..], 0));
    // Without a background the picture over that colour is the same.
    (plain.appearance.background, plain.appearance.transparent) = (None, true);
    let matte = Renderer::open(&dir, &plain).unwrap().image(0).unwrap();
    let opacity = matte.opacity.as_ref().unwrap();
    assert_eq!((opacity[0], opacity.iter().max()), (0, Some(&255)));
    for (i, _) in opacity.iter().enumerate().filter(|(_, a)| **a == 255) {
        assert_eq!(matte.rgb[3 * i..][..3], image.rgb[3 * i..][..3]);
    }
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn solids_lie_over_the_liquid_that_wets_them() {
    let dir = folder("over", Sample::Flat, 1);
    // A table up to 0.02 m, and a drop whose wetted side is most of a cell above it.
    let table = [[0.01, 0.0], [0.09, 0.0], [0.09, 0.02], [0.01, 0.02]];
    let low = 0.02 + 0.8e-3;
    let drop = [[0.03, low], [0.07, low], [0.07, 0.04], [0.03, 0.04]];
    for (name, outline, kinds) in [("solid_table", table, [0.0; 4]), ("liquid", drop, [2.0, 2.0, 0.0, 0.0])] {
        let positions = outline.map(|[x, y]| [x, y, 0.0]).to_vec();
        let mut mesh =
            PlyMesh { positions, edges: vec![[0, 1], [1, 2], [2, 3], [3, 0]], ..PlyMesh::default() };
        mesh.scalars.insert("kind".into(), kinds.to_vec());
        mesh.save(&dir.join(format!("frames/{name}_0000.ply"))).unwrap();
    }
    let mut options = RenderOptions { size: (640, 480).into(), ..small() };
    options.appearance.line = false;
    let image = Renderer::open(&dir, &options).unwrap().image(0).unwrap();
    // In the middle of the picture no air is seen between the last of the liquid and the first of the table.
    let pixel = |y: usize| &image.rgb[3 * (y * 640 + 320)..][..3];
    let liquid = (0..480).rev().find(|y| pixel(*y)[2] > pixel(*y)[0].saturating_add(60)).unwrap();
    let table = (0..480).find(|y| pixel(*y)[0] > pixel(*y)[2].saturating_add(20)).unwrap();
    assert!((liquid..table).all(|y| pixel(y).iter().any(|c| *c < 200)), "{liquid} {table}");
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn the_liquid_in_the_plane_covers_its_area() {
    let dir = folder("area", Sample::Flat, 1);
    std::fs::remove_file(dir.join("frames/solid_table_0000.ply")).unwrap();
    std::fs::remove_file(dir.join("frames/contact_line_0000.ply")).unwrap();
    common::blob([0.05, 0.03], 0.02, 0.0, 0.0, 600).save(&dir.join("frames/liquid_0000.ply")).unwrap();
    let options = RenderOptions { size: (640, 480).into(), ..small() };
    let image = Renderer::open(&dir, &options).unwrap().image(0).unwrap();
    // The domain is 0.1 m wide and fills the picture but for a border of 12 % of its height on either side.
    let scale = (640.0 - 2.0 * 0.12 * 480.0) / 0.1;
    let liquid = image.rgb.chunks(3).filter(|p| i32::from(p[2]) > i32::from(p[0]) + 60).count() as f64;
    let exact = std::f64::consts::PI * (0.02f64 * scale).powi(2);
    assert!((liquid / exact - 1.0).abs() < 0.03, "{liquid} {exact}");
    std::fs::remove_dir_all(dir).unwrap();
}

/// Pixels as red as the contact line.
fn red(image: &meniscus_view::Image) -> usize {
    let is_red = |p: &&[u8]| p[0] > 90 && i32::from(p[0]) > 2 * i32::from(p[1].max(p[2]));
    image.rgb.chunks(3).filter(is_red).count()
}

#[test]
fn the_contact_line_is_red_where_it_is_stored() {
    for sample in [Sample::Drop, Sample::Flat] {
        let dir = folder("line", sample, 1);
        let options = RenderOptions { size: (240, 160).into(), ..small() };
        let seen = red(&Renderer::open(&dir, &options).unwrap().image(0).unwrap());
        assert!(seen > 15, "{sample:?}: {seen}");
        std::fs::remove_file(dir.join("frames/contact_line_0000.ply")).unwrap();
        assert_eq!(red(&Renderer::open(&dir, &options).unwrap().image(0).unwrap()), 0, "{sample:?}");
        std::fs::remove_dir_all(dir).unwrap();
    }
}

#[test]
fn a_huge_plate_does_not_make_the_drop_tiny() {
    let options = RenderOptions { size: (240, 160).into(), ..small() };
    let dir = folder("huge-3d", Sample::Drop, 1);
    let before = red(&Renderer::open(&dir, &options).unwrap().image(0).unwrap());
    let huge = common::cuboid([-0.95, -0.95, 0.008], [1.05, 1.05, 0.012], 40);
    huge.save(&dir.join("frames/solid_plate_0000.ply")).unwrap();
    let after = red(&Renderer::open(&dir, &options).unwrap().image(0).unwrap());
    assert!(2 * after > before, "{before} {after}");
    std::fs::remove_dir_all(&dir).unwrap();

    let dir = folder("huge-2d", Sample::Flat, 1);
    let summary = std::fs::read_to_string(dir.join("summary.json")).unwrap();
    std::fs::write(dir.join("summary.json"), summary.replace("[0.1, 0.06]", "[2.0, 0.5]")).unwrap();
    let mut plate = PlyMesh { edges: vec![[0, 1], [1, 2], [2, 3], [3, 0]], ..PlyMesh::default() };
    plate.positions = vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [2.0, 0.01, 0.0], [0.0, 0.01, 0.0]];
    plate.save(&dir.join("frames/solid_table_0000.ply")).unwrap();
    let image = Renderer::open(&dir, &options).unwrap().image(0).unwrap();
    let liquid = image.rgb.chunks(3).filter(|p| i32::from(p[2]) > i32::from(p[0]) + 60).count();
    assert!(liquid > 240 * 160 / 8, "{liquid}");
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn odd_folders_are_errors_or_pictures_but_never_panics() {
    let dir = folder("odd", Sample::Drop, 2);
    std::fs::write(dir.join("frames/liquid_0001.ply"), "ply\nformat ascii 1.0\n").unwrap();
    let error = Renderer::open(&dir, &small()).unwrap_err().to_string();
    assert!(error.contains("liquid_0001.ply"), "{error}");
    std::fs::write(dir.join("summary.json"), "{").unwrap();
    assert!(RunFolder::open(&dir).unwrap_err().to_string().contains("summary.json"));
    std::fs::remove_file(dir.join("summary.json")).unwrap();
    let empty = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nend_header\n";
    for n in 0..2 {
        std::fs::write(dir.join(format!("frames/liquid_000{n}.ply")), empty).unwrap();
    }
    Renderer::open(&dir, &small()).unwrap().image(1).unwrap();
    make_page(&dir, &PageOptions::default()).unwrap();
    for what in ["contact_line", "solid_plate"] {
        (0..2).for_each(|n| std::fs::remove_file(dir.join(format!("frames/{what}_000{n}.ply"))).unwrap());
    }
    Renderer::open(&dir, &small()).unwrap().image(0).unwrap();
    assert!(RunFolder::open(&dir.join("nowhere")).unwrap_err().to_string().contains("nowhere"));
    std::fs::remove_dir_all(dir).unwrap();
}
