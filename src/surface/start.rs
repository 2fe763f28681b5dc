//! Where to start looking for a place: a grid of nearby vertices.

use crate::mesh::NONE;
use crate::simulation::{Surface, surface::Starts};
use glam::DVec3;

impl Surface {
    /// A sub-plate close to a direction: a good hint for [`SphereMesh::locate`] and
    /// [`SphereMesh::nearest`], which then walk a step or two on a mesh of any size.
    ///
    /// [`SphereMesh::locate`]: crate::mesh::SphereMesh::locate
    /// [`SphereMesh::nearest`]: crate::mesh::SphereMesh::nearest
    #[must_use]
    pub fn start(&self, direction: DVec3) -> u32 {
        let starts = self.kept.starts.get_or_init(|| self.find_starts());
        let cell = starts.cell(direction);
        starts.cells.get(cell).copied().unwrap_or(0)
    }

    /// About one cell per sub-plate. A cell without any takes the one nearest to its centre.
    fn find_starts(&self) -> Starts {
        let side = (self.mesh.vertex_count() as f64 / 6.0)
            .sqrt()
            .ceil()
            .max(1.0) as u32;
        let mut starts = Starts {
            side,
            cells: vec![NONE; 6 * (side * side) as usize],
        };
        let mut near = NONE;
        for (vertex, &site) in (0..).zip(self.mesh.sites()) {
            let cell = starts.cell(site);
            if starts.cells[cell] == NONE && !self.mesh.is_detached(vertex) {
                starts.cells[cell] = vertex;
            }
        }
        for cell in 0..starts.cells.len() {
            if starts.cells[cell] == NONE {
                starts.cells[cell] = self.mesh.nearest(starts.centre(cell), near);
            }
            near = starts.cells[cell];
        }
        starts
    }
}

impl Starts {
    /// The cell of a direction of any length; some cell if it is not finite.
    fn cell(&self, direction: DVec3) -> usize {
        let DVec3 { x, y, z } = direction;
        let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
        let (face, u, v, height) = if ax >= ay && ax >= az {
            (usize::from(x < 0.0), y, z, ax)
        } else if ay >= az {
            (2 + usize::from(y < 0.0), z, x, ay)
        } else {
            (4 + usize::from(z < 0.0), x, y, az)
        };
        // Casts saturate, and what is not a number becomes 0.
        let half = 0.5 * f64::from(self.side);
        let scale = half / height;
        let column = ((u * scale + half) as u32).min(self.side - 1) as usize;
        let row = ((v * scale + half) as u32).min(self.side - 1) as usize;
        let side = self.side as usize;
        (face * side + row) * side + column
    }

    /// A direction in the middle of a cell.
    fn centre(&self, cell: usize) -> DVec3 {
        let side = self.side as usize;
        let across = |place: usize| (2 * place + 1) as f64 / side as f64 - 1.0;
        let (u, v) = (across(cell % side), across(cell / side % side));
        let face = cell / (side * side);
        let height = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
        match face / 2 {
            0 => DVec3::new(height, u, v),
            1 => DVec3::new(v, height, u),
            _ => DVec3::new(u, v, height),
        }
        .normalize()
    }
}
