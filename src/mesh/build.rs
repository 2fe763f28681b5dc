//! Construction: a planar Delaunay triangulation under stereographic projection.

use glam::DVec3;
use spade::{DelaunayTriangulation, HasPosition, Point2, Triangulation};
use thiserror::Error;

use super::geometry::unit;
use super::{Edge, EdgePayload, HalfEdge, NONE, RepairError, SphereMesh, Vertex};

/// Why sites have no triangulation.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum BuildError {
    /// Fewer than four sites.
    #[error("a closed mesh needs at least 4 sites, got {0}")]
    TooFewSites(usize),
    /// More sites than half-edges can be numbered.
    #[error("{0} sites exceed the numbering of the mesh")]
    TooManySites(usize),
    /// A site is not finite, or zero.
    #[error("site {0} has no direction")]
    NoDirection(usize),
    /// Two sites have the same direction, or too similar ones to tell them apart.
    #[error("sites {0} and {1} coincide")]
    Duplicate(usize, usize),
    /// The convex hull of the sites does not enclose the centre: all are on one hemisphere, or on
    /// one circle.
    #[error("the sites do not surround the centre of the sphere")]
    NotAroundCentre,
    /// Sites lie closer together than coordinates can express.
    #[error("the sites have no exact triangulation: {0}")]
    Unresolved(#[from] RepairError),
}

/// A site on the plane.
struct Projected {
    vertex: Vertex,
    position: Point2<f64>,
}

impl HasPosition for Projected {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        self.position
    }
}

impl<E: EdgePayload> SphereMesh<E> {
    /// Delaunay triangulation of `sites`; vertex `i` is site `i`.
    ///
    /// Sites are normalised; those of unit length to within rounding are kept bit for bit. Edges
    /// are numbered along the vertices, so sites in [`hilbert_order`](super::hilbert_order) give
    /// the best memory locality.
    ///
    /// # Errors
    ///
    /// See [`BuildError`].
    pub fn build(mut sites: Vec<DVec3>) -> Result<Self, BuildError> {
        if sites.len() < 4 {
            return Err(BuildError::TooFewSites(sites.len()));
        }
        if sites.len() > (NONE / 6) as usize {
            return Err(BuildError::TooManySites(sites.len()));
        }
        for (i, site) in sites.iter_mut().enumerate() {
            *site = unit(*site).ok_or(BuildError::NoDirection(i))?;
        }
        let plane = triangulate_plane(&sites)?;
        let mut mesh = close_at_pole(sites, &plane);
        // Projection rounds; the exact predicate on the sphere has the last word.
        let queue = mesh.edges_to_repair(0..mesh.edge_slots());
        let blocked = mesh.lawson(queue, &mut Vec::new())?;
        let folded: Vec<HalfEdge> = mesh.triangles().filter(|&h| mesh.is_inverted(h)).collect();
        if !folded.is_empty() && !mesh.surrounds_centre() {
            return Err(BuildError::NotAroundCentre);
        }
        // Flips alone do not free a vertex that the rounding put into a fold.
        let suspects = folded
            .into_iter()
            .map(|h| mesh.edge_of(h))
            .chain(blocked)
            .collect();
        mesh.untangle(suspects, &mut Vec::new(), true)?;
        mesh.renumber_edges();
        Ok(mesh)
    }

    /// Whether the surface, folded or not, winds around the centre.
    fn surrounds_centre(&self) -> bool {
        let area: f64 = self.triangles().map(|h| self.triangle_area(h)).sum();
        // 4π times the number of windings; half that if the centre lies on the surface.
        area > 3.0 * std::f64::consts::PI
    }
}

/// Planar Delaunay triangulation of all sites but the first, seen from the first.
///
/// Circles through other sites stay circles, so the triangles are those of the sphere.
fn triangulate_plane(sites: &[DVec3]) -> Result<DelaunayTriangulation<Projected>, BuildError> {
    let pole = sites[0];
    // A left-handed frame: counter-clockwise on the plane is counter-clockwise from outside.
    let (v, u) = pole.any_orthonormal_pair();
    let mut projected = Vec::with_capacity(sites.len() - 1);
    for (&site, vertex) in sites.iter().zip(0..).skip(1) {
        // 1 - cos of the distance, without cancellation near the pole.
        let depth = 0.5 * site.distance_squared(pole);
        let position = Point2::new(planar(site.dot(u) / depth), planar(site.dot(v) / depth));
        if spade::validate_vertex(&position).is_err() {
            return Err(BuildError::Duplicate(0, vertex as usize));
        }
        projected.push(Projected { vertex, position });
    }
    let positions: Vec<Point2<f64>> = projected.iter().map(HasPosition::position).collect();
    let plane = DelaunayTriangulation::<Projected>::bulk_load(projected)
        .map_err(|_| BuildError::NotAroundCentre)?;
    if plane.num_vertices() < positions.len() {
        return Err(duplicate(&positions));
    }
    if plane.num_inner_faces() == 0 {
        return Err(BuildError::NotAroundCentre);
    }
    Ok(plane)
}

/// A coordinate in the range that the planar triangulation accepts.
fn planar(x: f64) -> f64 {
    // Adding zero makes -0 equal +0 in every order.
    if x.abs() < 1e-40 { 0.0 } else { x + 0.0 }
}

/// Two vertices, from 1 on, at the same one of the positions, which are known not to be distinct.
fn duplicate(positions: &[Point2<f64>]) -> BuildError {
    let mut order: Vec<usize> = (0..positions.len()).collect();
    order.sort_by(|&i, &j| {
        let (p, q) = (positions[i], positions[j]);
        p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y))
    });
    order
        .windows(2)
        .find(|pair| positions[pair[0]] == positions[pair[1]])
        // The sort is stable: the smaller number comes first.
        .map_or(BuildError::NotAroundCentre, |pair| {
            BuildError::Duplicate(pair[0] + 1, pair[1] + 1)
        })
}

/// Copies the planar triangulation and joins its boundary to the pole, vertex 0.
fn close_at_pole<E: EdgePayload>(
    sites: Vec<DVec3>,
    plane: &DelaunayTriangulation<Projected>,
) -> SphereMesh<E> {
    let edges = 3 * sites.len() - 6;
    let mut mesh = SphereMesh {
        vertex_edge: vec![NONE; sites.len()],
        origin: vec![NONE; 2 * edges],
        next: vec![NONE; 2 * edges],
        payload: vec![E::default(); edges],
        free: Vec::new(),
        sites,
    };
    // The outward spoke of each boundary vertex is kept as its edge until the fan is closed.
    let mut boundary: Vec<HalfEdge> = Vec::new();
    for half in plane.directed_edges() {
        let h = half.fix().index();
        let vertex = half.from().data().vertex;
        mesh.origin[h] = vertex;
        mesh.next[h] = half.next().fix().index() as HalfEdge;
        mesh.vertex_edge[vertex as usize] = h as HalfEdge;
        if half.is_outer_edge() {
            boundary.push(h as HalfEdge);
        }
    }
    let first_spoke = plane.num_undirected_edges() as Edge;
    for (&h, spoke) in boundary.iter().zip(first_spoke..) {
        let vertex = mesh.origin(h);
        mesh.origin[2 * spoke as usize] = vertex;
        mesh.origin[2 * spoke as usize + 1] = 0;
        mesh.vertex_edge[vertex as usize] = 2 * spoke;
        mesh.vertex_edge[0] = 2 * spoke + 1;
    }
    for &h in &boundary {
        let from = mesh.vertex_edge[mesh.origin(h) as usize];
        let to = mesh.vertex_edge[mesh.dest(h) as usize];
        mesh.link_triangle(h, to, mesh.twin(from));
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    fn build(sites: &[[f64; 3]]) -> Result<SphereMesh, BuildError> {
        SphereMesh::build(sites.iter().map(|&p| DVec3::from(p)).collect())
    }

    const OCTAHEDRON: [[f64; 3]; 6] = [
        [1., 0., 0.],
        [-1., 0., 0.],
        [0., 1., 0.],
        [0., -1., 0.],
        [0., 0., 1.],
        [0., 0., -1.],
    ];

    #[test]
    fn smallest_meshes() {
        let tetrahedron = [[1., 1., 1.], [1., -1., -1.], [-1., 1., -1.], [-1., -1., 1.]];
        let mesh = build(&tetrahedron).unwrap();
        mesh.check().unwrap();
        assert_eq!((mesh.vertex_count(), mesh.edge_count()), (4, 6));
        let bipyramid = [
            [0., 0., 1.],
            [0., 0., -1.],
            [1., 0., 0.],
            [-1., 2., 0.],
            [-1., -2., 0.],
        ];
        build(&bipyramid).unwrap().check().unwrap();
        build(&OCTAHEDRON).unwrap().check().unwrap();
    }

    #[test]
    fn unit_sites_are_kept() {
        let mesh = build(&OCTAHEDRON).unwrap();
        assert_eq!(mesh.site(3), DVec3::NEG_Y);
        let again = SphereMesh::<()>::build(mesh.sites().to_vec()).unwrap();
        assert_eq!(again, mesh);
    }

    #[test]
    fn bad_sites_are_named() {
        assert_eq!(build(&OCTAHEDRON[..3]), Err(BuildError::TooFewSites(3)));
        let with = |extra: [f64; 3]| build(&[&OCTAHEDRON[..], &[extra]].concat());
        assert_eq!(with([0.; 3]), Err(BuildError::NoDirection(6)));
        assert_eq!(with([f64::NAN, 0., 1.]), Err(BuildError::NoDirection(6)));
        assert_eq!(
            with([f64::INFINITY, 0., 1.]),
            Err(BuildError::NoDirection(6))
        );
        assert_eq!(with([0., -3., 0.]), Err(BuildError::Duplicate(3, 6)));
        assert_eq!(with([2., 0., 0.]), Err(BuildError::Duplicate(0, 6)));
    }

    #[test]
    fn open_hulls_are_refused() {
        assert_eq!(build(&OCTAHEDRON[..4]), Err(BuildError::NotAroundCentre));
        assert_eq!(build(&OCTAHEDRON[..5]), Err(BuildError::NotAroundCentre));
        let cap = [
            [0.1, 0., 1.],
            [0., 0.1, 1.],
            [-0.1, 0., 1.],
            [0., -0.1, 1.],
            [0., 0., 1.],
        ];
        assert_eq!(build(&cap), Err(BuildError::NotAroundCentre));
    }
}
