//! What is no solid is refused, by name and with its place; what is told to held vertices happens.

use crate::lattice::{block, free, linear};
use meniscus_elastic::{
    Anchor, AnchorMotion, ConstitutiveLaw, Elastic, ElasticError, ElasticSpecification, ElementOrder,
    StiffnessBlock, TangentWeights,
};
use meniscus_numerics::{Matrix, Vector};

fn fine() -> ElasticSpecification<2> {
    free(block([2, 2], [1.0, 1.0]), 1.0, linear(1.0, 0.3))
}

fn refused(change: impl Fn(&mut ElasticSpecification<2>)) -> ElasticError {
    let mut description = fine();
    change(&mut description);
    let error = Elastic::new(description).unwrap_err();
    println!("{error}");
    error
}

#[test]
fn refusals() {
    use ElasticError::*;
    assert!(Elastic::new(fine()).is_ok());
    assert!(matches!(refused(|d| d.mesh.simplices.clear()), Empty));
    assert!(matches!(refused(|d| d.mesh.simplices[1].others.swap(0, 1)), Inverted { element: 1, .. }));
    assert!(matches!(
        refused(|d| d.mesh.positions[4] = Vector::from([1e-6, 0.0])),
        Flat { .. } | Inverted { .. }
    ));
    assert!(matches!(
        refused(|d| d.mesh.simplices[3].root = 99),
        NoSuchVertex { element: 3, vertex: 99, count: 9 }
    ));
    assert!(matches!(
        refused(|d| d.mesh.positions.push(Vector::zeros())),
        UnreferencedVertex { vertex: 9, .. }
    ));
    assert!(matches!(refused(|d| d.mesh.positions[2][1] = f64::NAN), NonFinitePosition { vertex: 2 }));
    for poisson_ratio in [0.5, -1.0, 0.7, f64::NAN] {
        let law = ConstitutiveLaw::corotated(1.0, poisson_ratio, ElementOrder::Linear);
        assert!(matches!(refused(|d| d.law = law), Material { name: "Poisson's ratio", .. }));
    }
    assert!(matches!(refused(|d| d.law = linear(-1.0, 0.3)), Material { .. }));
    assert!(matches!(refused(|d| d.law = ConstitutiveLaw::Springs { stiffness: -1.0 }), Material { .. }));
    assert!(matches!(refused(|d| d.density = 0.0), Material { .. }));
    assert!(matches!(refused(|d| d.damping_ratio = -0.1), Material { .. }));
    let anchor = |vertices: &[u32]| Anchor { vertices: vertices.to_vec(), motion: AnchorMotion::Fixed };
    assert!(matches!(
        refused(|d| d.anchors = vec![Anchor::within(&d.mesh, |x| x[0] > 2.0)]),
        EmptyAnchor { anchor: 0 }
    ));
    assert!(matches!(refused(|d| d.anchors = vec![anchor(&[77])]), NoSuchAnchorVertex { vertex: 77, .. }));
    assert!(matches!(
        refused(|d| d.anchors = vec![anchor(&[1]), anchor(&[1])]),
        OverlappingAnchors { vertex: 1, .. }
    ));
    assert!(matches!(refused(|d| d.anchors = vec![Anchor::within(&d.mesh, |_| true)]), AllAnchored));
    let late = AnchorMotion::Keyframes(vec![(1.0, Vector::zeros()), (0.5, Vector::zeros())]);
    let anchors = vec![Anchor { vertices: vec![0], motion: late }];
    assert!(matches!(refused(|d| d.anchors = anchors.clone()), Keyframes { keyframe: 1, .. }));
    let body = Elastic::new(fine()).unwrap();
    let far = StiffnessBlock { first: 0, second: 8, block: Matrix::<2>::identity() };
    let none = vec![Vector::zeros(); body.masses().len()];
    let error = body.linear_static_displacements(&none, &[far]).unwrap_err();
    assert!(matches!(error, NotNeighbours { first: 0, second: 8 }));
}

#[test]
fn held_vertices_go_where_they_are_told() {
    let mesh = crate::lattice::quadratic([2, 2], [1.0, 1.0]);
    let mut description = free(mesh, 1.0, crate::lattice::rubber(1.0, 0.3));
    let path = vec![(0.0, Vector::zeros()), (0.5, Vector::from([0.2, 0.1])), (1.0, Vector::from([0.2, 0.0]))];
    description.anchors = vec![Anchor {
        motion: AnchorMotion::Keyframes(path),
        ..Anchor::within(&description.mesh, |x| x[0] < 0.1)
    }];
    description.damping_ratio = 0.5;
    let body = Elastic::new(description).unwrap();
    let h = 0.05;
    let mut state = body.rest_state(h);
    let none = vec![Vector::zeros(); 9];
    for k in 1..=600 {
        body.step(&mut state, h, &none).unwrap();
        if k == 10 {
            assert!((state.positions[0] - Vector::from([0.2, 0.1])).norm() < 1e-14);
        }
    }
    for (x, rest) in state.positions.iter().zip(&body.rest_mesh().positions) {
        assert!((x - rest - Vector::from([0.2, 0.0])).norm() < 1e-5, "the rest follows: {x}");
    }
}

#[test]
fn small_displacements_balance_forces() {
    let mut description = fine();
    description.anchors = vec![Anchor::within(&description.mesh, |x| x[0] < 0.1)];
    let body = Elastic::new(description).unwrap();
    let extra = StiffnessBlock { first: 4, second: 5, block: Matrix::<2>::new(0.1, 0.2, 0.0, 0.3) };
    let diagonal = |v| StiffnessBlock { first: v, second: v, block: Matrix::<2>::identity() };
    let extra = [extra, diagonal(4), diagonal(5)];
    let b = crate::lattice::Noise(1).vectors::<2>(9);
    let x = body.linear_static_displacements(&b, &extra).unwrap();
    let mut matrix = body.tangent(
        &body.rest_mesh().positions,
        TangentWeights { stiffness: 1.0, project_psd: true, viscosity: 0.0 },
    );
    assert!(extra.iter().all(|e| matrix.add(e.first, e.second, &e.block)));
    let mut back = vec![Vector::zeros(); 9];
    matrix.add_product(&x, &mut back);
    for v in 0..9 {
        if body.anchored()[v] {
            assert!(x[v].norm() == 0.0);
        } else {
            assert!((back[v] - b[v]).norm() < 1e-13);
        }
    }
}
