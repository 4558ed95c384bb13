use super::*;

fn ball<const D: usize>(x: &Vector<D>) -> f64 {
    (x - Vector::from_fn(|a, _| 0.487 + 0.03 * a as f64)).norm() - 0.271
}

fn cut<const D: usize>(cells: usize, signed_distance: &(dyn Fn(&Vector<D>) -> f64 + Sync)) -> CutCells<D> {
    let mut cut = CutCells::uncut(Grid::new([cells; D], 1.0 / cells as f64));
    cut.rebuild(
        &[EmbeddedBoundary { signed_distance, bounds: [Vector::repeat(0.1), Vector::repeat(0.9)] }],
        &Tiles::all(cut.open_fraction.grid),
    );
    cut
}

fn surface_closes<const D: usize>(distance: &(dyn Fn(&Vector<D>) -> f64 + Sync)) {
    let cut = cut::<D>(if D == 2 { 50 } else { 25 }, distance);
    let area = cut.cells.iter().fold(Vector::zeros(), |s: Vector<D>, w| s + w.area_vector);
    let moment =
        cut.cells.iter().fold([0.0; 3], |m: [f64; 3], w| std::array::from_fn(|i| m[i] + w.moment[i]));
    // The force of a unit pressure gradient is the volume of the body along the gradient, and zero across it.
    let grid = cut.open_fraction.grid;
    let push = |w: &CutCell<D>| {
        let x = grid.center(grid.lattice().coordinates(w.cell as usize)) / grid.dx;
        w.first_moment + w.area_vector * x.transpose()
    };
    let push = cut.cells.iter().fold(Matrix::<D>::zeros(), |s, w| s + push(w));
    let across = push - Matrix::identity() * push[(0, 0)];
    assert!(across.amax() < 1e-9, "{D}D: {push}");
    assert!(area.amax() < 1e-11, "{D}D: {area}");
    assert!(moment.iter().all(|m| m.abs() < 1e-9), "{D}D: {moment:?}");
}

#[test]
fn the_surface_of_a_body_closes_to_rounding() {
    surface_closes::<2>(&ball);
    surface_closes::<3>(&ball);
    // Oblique bars, 3 (2D) or 1.5 (3D) cells thick.
    let bar = |x: f64, y: f64| (0.8 * x + 0.6 * y - 0.7).abs() - 0.03;
    surface_closes::<2>(&|x| bar(x[0], x[1]).max((x - Vector::repeat(0.5)).norm() - 0.35));
    surface_closes::<3>(&|x| {
        bar(x[0], x[2]).min(bar(x[1], x[0])).max((x - Vector::repeat(0.5)).norm() - 0.35)
    });
}

/// Relative error of the body's volume, found by the divergence theorem.
fn volume_error<const D: usize>(cells: usize) -> f64 {
    let cut = cut::<D>(cells, &ball);
    let grid = cut.open_fraction.grid;
    let at_surface = |w: &CutCell<D>| {
        let x = grid.center(grid.lattice().coordinates(w.cell as usize));
        let n = w.area_vector.normalize();
        // −n is the body's outward normal; the surface lies where the distance is zero.
        (x + n * ball(&x)).dot(&-w.area_vector)
    };
    let volume = cut.cells.iter().map(at_surface).sum::<f64>() / D as f64 * grid.face_area();
    let exact = match D {
        2 => std::f64::consts::PI * 0.271f64.powi(2),
        _ => 4.0 / 3.0 * std::f64::consts::PI * 0.271f64.powi(3),
    };
    volume / exact - 1.0
}

#[test]
fn the_surface_is_second_order() {
    for (coarse, fine) in
        [(volume_error::<2>(20), volume_error::<2>(80)), (volume_error::<3>(16), volume_error::<3>(64))]
    {
        assert!(coarse.abs() < 0.02 && fine.abs() < coarse.abs() / 10.0, "{coarse:e}, {fine:e}");
    }
}

fn plane_is_exact<const D: usize>() {
    let normal = Vector::<D>::from_fn(|a, _| [0.48, 0.6, 0.64][a]).normalize();
    let offset = 0.55;
    let mut cut = CutCells::uncut(Grid::<D>::new([9; D], 1.0 / 9.0));
    let distance = |x: &Vector<D>| x.dot(&normal) - offset;
    cut.rebuild(
        &[EmbeddedBoundary {
            signed_distance: &distance,
            bounds: [Vector::repeat(-1.0), Vector::repeat(2.0)],
        }],
        &Tiles::all(cut.open_fraction.grid),
    );
    for w in &cut.cells {
        let along = w.area_vector.normalize().dot(&-normal);
        assert!((along - 1.0).abs() < 1e-9 || w.area_vector.norm() < 0.05, "{w:?}");
        // The moment is that of the area vector at its centroid on the plane, so it is orthogonal to the area vector.
        let lean: f64 = if D == 2 { 0.0 } else { (0..D).map(|a| w.moment[a] * w.area_vector[a]).sum() };
        assert!(lean.abs() < 1e-9, "{w:?}");
    }
    // The open fractions of a solid and of its complement add up to one.
    let other = |x: &Vector<D>| -distance(x);
    let mut rest = CutCells::uncut(cut.open_fraction.grid);
    rest.rebuild(
        &[EmbeddedBoundary { signed_distance: &other, bounds: [Vector::repeat(-1.0), Vector::repeat(2.0)] }],
        &Tiles::all(rest.open_fraction.grid),
    );
    for a in 0..D {
        for (open, shut) in cut.open_fraction.axes[a].iter().zip(&rest.open_fraction.axes[a]) {
            assert!((open + shut - 1.0).abs() < 1e-12, "{open} {shut}");
        }
    }
}

#[test]
fn a_plane_is_cut_exactly() {
    plane_is_exact::<2>();
    plane_is_exact::<3>();
}

#[test]
fn a_solid_that_leaves_leaves_nothing_behind() {
    let mut cut = cut::<3>(20, &ball);
    cut.rebuild(&[], &Tiles::all(cut.open_fraction.grid));
    assert!(cut.cells.is_empty() && cut.open_fraction.axes.iter().flatten().all(|s| *s == 1.0));
}

/// With some active tiles only, their cells are cut as if all tiles were active.
fn tiles_are_cut_alike<const D: usize>() {
    let grid = Grid::<D>::new([32; D], 1.0 / 32.0);
    let mut phi = vec![1.0; grid.lattice().len()];
    phi[grid.lattice().index([2; D])] = -1.0;
    let tiles = Tiles::all(grid).around_negative(&phi);
    let solid =
        EmbeddedBoundary { signed_distance: &ball, bounds: [Vector::repeat(0.1), Vector::repeat(0.9)] };
    let (mut some, mut all) = (CutCells::uncut(grid), CutCells::uncut(grid));
    some.rebuild(&[solid], &tiles);
    all.rebuild(&[solid], &Tiles::all(grid));
    // Faces that are opened after the cells are cut stay cut.
    let mut late = CutCells::unopened(grid);
    late.rebuild(&[solid], &tiles);
    late.open_tiles(&tiles.dilated());
    let at = |cell: u32| grid.lattice().coordinates(cell as usize);
    let inside: Vec<_> = all.cells.iter().filter(|w| tiles.is_active(at(w.cell))).copied().collect();
    assert!(!inside.is_empty() && inside.len() < all.cells.len());
    assert_eq!(some.cells, inside);
    for cell in (0..grid.lattice().len() as u32).filter(|c| tiles.is_active(at(*c))) {
        assert_eq!(some.distance_cells(cell as usize), all.distance_cells(cell as usize));
        for (a, up) in (0..2 * D).map(|n| (n / 2, n % 2)) {
            let mut face = at(cell);
            face[a] += up;
            let face = grid.face_lattice(a).index(face);
            assert_eq!(some.open_fraction.axes[a][face], all.open_fraction.axes[a][face]);
            assert_eq!(late.open_fraction.axes[a][face], all.open_fraction.axes[a][face]);
        }
    }
}

#[test]
fn what_is_cut_does_not_depend_on_which_tiles_are_active() {
    tiles_are_cut_alike::<2>();
    tiles_are_cut_alike::<3>();
}

#[test]
fn a_thin_wall_parts_the_cells_of_a_box() {
    let grid = cut::<2>(20, &|x| (x[0] - 0.5).abs() - 0.04);
    let found = grid.connected_cells([7, 10], [[5, 8], [14, 12]]);
    assert!(found.contains(&[5, 8]) && found.contains(&[9, 11]));
    assert!(found.iter().all(|p| p[0] < 10 && (8..12).contains(&p[1])), "{found:?}");
}
