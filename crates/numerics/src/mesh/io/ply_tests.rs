use super::*;

fn sample() -> PlyMesh {
    let mut mesh = PlyMesh {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 1e-9], [0.0, 1.0 / 3.0, 0.0], [0.1, 0.2, 0.3]],
        faces: vec![[0, 1, 2], [0, 2, 3]],
        edges: vec![[0, 3]],
        comments: vec!["time 0.25".into()],
        ..PlyMesh::default()
    };
    mesh.scalars.insert("kind".into(), vec![0.0, 1.0, 2.0, 0.0]);
    mesh.scalars.insert("speed".into(), vec![0.1, 0.2, 0.3, 0.4]);
    mesh
}

fn bytes(mesh: &PlyMesh) -> Vec<u8> {
    let mut b = Vec::new();
    mesh.write(&mut b).unwrap();
    b
}

#[test]
fn binary_round_trip_keeps_every_bit() {
    let mesh = sample();
    let back = PlyMesh::from_bytes(&bytes(&mesh)).unwrap();
    assert_eq!(back, mesh);
    assert_eq!(back.time(), Some(0.25));
}

/// Files of earlier versions have an element `edge`.
#[test]
fn edges_are_a_property_of_vertices_and_are_read_as_an_element_too() {
    // Two edges begin at 3, in two loops that touch there.
    let edges = vec![[0, 3], [1, 3], [3, 0], [3, 1]];
    let sample = PlyMesh { faces: Vec::new(), edges, ..sample() };
    let written = bytes(&sample);
    let header = String::from_utf8_lossy(&written);
    let told = "property int next\nproperty int next_2\nelement face 0\n";
    assert!(!header.contains("element edge") && header.contains(told), "{header}");
    assert_eq!(PlyMesh::from_bytes(&written).unwrap(), sample);

    let mut old = bytes(&PlyMesh { edges: Vec::new(), ..sample.clone() });
    let end = old.windows(11).position(|w| w == b"end_header\n").unwrap();
    old.splice(end..end, *b"element edge 4\nproperty int vertex1\nproperty int vertex2\n");
    sample.edges.iter().flatten().for_each(|v| old.extend_from_slice(&v.to_le_bytes()));
    assert_eq!(PlyMesh::from_bytes(&old).unwrap(), sample);

    let text = |next: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty int next\nend_header\n0 0 1\n1 1 {next}\n"
        )
    };
    assert_eq!(PlyMesh::from_bytes(text("-1").as_bytes()).unwrap().edges, [[0, 1]]);
    assert!(["2", "-2"].iter().all(|next| PlyMesh::from_bytes(text(next).as_bytes()).is_err()));
}

#[test]
fn file_round_trip_and_error_names_the_path() {
    let dir = std::env::temp_dir().join(format!("meniscus-ply-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let path = dir.join("a.ply");
    sample().save(&path).unwrap();
    assert_eq!(PlyMesh::load(&path).unwrap(), sample());
    let missing = PlyMesh::load(&dir.join("missing.ply")).unwrap_err().to_string();
    assert!(missing.contains("missing.ply"), "{missing}");
    std::fs::remove_dir_all(&dir).unwrap();
}

#[test]
fn ascii_polygons_become_triangles() {
    let text = "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nelement vertex 5\r\nproperty float x\r\n\
        property float y\r\nproperty float z\r\nelement face 2\r\nproperty list uchar int vertex_index\r\n\
        property uchar red\r\nelement other 1\r\nproperty int a\r\nelement edge 1\r\nproperty int vertex1\r\n\
        property int vertex2\r\nend_header\r\n0 0 0\r\n1 0 0\r\n1 1 0\r\n0 1 0\r\n0.5 2 -1e-3\r\n\
        4 0 1 2 3 255\r\n3 3 2 4 0\r\n7\r\n0 4\r\n";
    let mesh = PlyMesh::from_bytes(text.as_bytes()).unwrap();
    assert_eq!(mesh.faces, vec![[0, 1, 2], [0, 2, 3], [3, 2, 4]]);
    assert_eq!(mesh.edges, vec![[0, 4]]);
    assert_eq!(mesh.positions[4], [0.5, 2.0, -1e-3]);
}

#[test]
fn big_endian_floats() {
    let mut b = b"ply\nformat binary_big_endian 1.0\nelement vertex 1\nproperty float x\n\
        property float y\nproperty short q\nend_header\n"
        .to_vec();
    b.extend_from_slice(&1.5f32.to_be_bytes());
    b.extend_from_slice(&(-2.0f32).to_be_bytes());
    b.extend_from_slice(&(-7i16).to_be_bytes());
    let mesh = PlyMesh::from_bytes(&b).unwrap();
    assert_eq!(mesh.positions, vec![[1.5, -2.0, 0.0]]);
    assert_eq!(mesh.scalars["q"], vec![-7.0]);
}

#[test]
fn malformed_files_are_errors() {
    let head = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n";
    let bad: Vec<Vec<u8>> = vec![
        Vec::new(),
        b"solid".to_vec(),
        b"ply\nformat ascii 1.0\n".to_vec(),
        b"ply\nend_header\n".to_vec(),
        b"ply\nformat ascii 1.0\nproperty float x\nend_header\n".to_vec(),
        b"ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n1\n".to_vec(),
        b"ply\nformat ascii 1.0\nelement vertex 99999999999999\nproperty float x\nproperty float y\nend_header\n1 1\n"
            .to_vec(),
        b"ply\nformat binary_little_endian 1.0\nelement vertex 9999999\nproperty float x\nproperty float y\nend_header\n"
            .to_vec(),
        format!("{head}end_header\n1 nonsense\n").into_bytes(),
        format!("{head}end_header\n1 nan\n").into_bytes(),
        format!("{head}element face 1\nproperty list uchar int vertex_indices\nend_header\n1 1\n3 0 0 1\n")
            .into_bytes(),
        format!("{head}element face 1\nproperty list uchar int vertex_indices\nend_header\n1 1\n3 0 0 -1\n")
            .into_bytes(),
        format!("{head}element face 1\nproperty list uchar int vertex_indices\nend_header\n1 1\n2 0 0\n")
            .into_bytes(),
        format!("{head}element edge 1\nproperty int vertex1\nend_header\n1 1\n0\n").into_bytes(),
    ];
    for b in bad {
        assert!(PlyMesh::from_bytes(&b).is_err(), "{}", String::from_utf8_lossy(&b));
    }
}

#[test]
fn any_truncation_or_flipped_byte_never_panics() {
    let whole = bytes(&sample());
    for n in 0..whole.len() {
        assert!(PlyMesh::from_bytes(&whole[..n]).is_err(), "cut at {n}");
    }
    for i in 0..whole.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut b = whole.clone();
            b[i] ^= flip;
            let _ = PlyMesh::from_bytes(&b);
        }
    }
}
