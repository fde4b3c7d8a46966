//! Meshes on the GPU: uploaded when they are first drawn, cluster by cluster, into pages of vertices and indices.

use bytemuck::{Pod, Zeroable};
use enfilade::{Mesh, Transform};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use wgpu::{Buffer, BufferUsages, Device, Queue};

/// Size of a page of vertices. A mesh that does not fit into a page is split between its clusters.
const VERTICES: usize = 1 << 19;
const INDICES: usize = 3 << 19;

/// A corner of a triangle.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Vertex {
    position: [f32; 3],
    normal: [i16; 4],
    uv: [f32; 2],
    color: [u16; 4],
}

pub(crate) const VERTEX_ATTRIBUTES: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Snorm16x4, 2 => Float32x2, 3 => Unorm16x4];

pub(crate) struct Page {
    pub(crate) vertices: Buffer,
    pub(crate) indices: Buffer,
    vertices_used: usize,
    indices_used: usize,
}

/// Clusters of a mesh in one page.
pub(crate) struct Piece {
    pub(crate) page: u32,
    /// Their range in the index buffer of the mesh ([`Mesh::triangle_indices`]).
    pub(crate) of_mesh: Range<u32>,
    /// Start of that range in the index buffer of the page.
    start: u32,
}

impl Piece {
    /// Returns the part of a range of the mesh's indices that is in this piece, as a range of the page's.
    pub(crate) fn part(&self, range: &Range<u32>) -> Option<Range<u32>> {
        let [start, end] = [
            range.start.max(self.of_mesh.start),
            range.end.min(self.of_mesh.end),
        ];
        let moved = |at: u32| at - self.of_mesh.start + self.start;
        (start < end).then(|| moved(start)..moved(end))
    }
}

pub(crate) struct Resident {
    pub(crate) pieces: Vec<Piece>,
    /// Vertices are relative to the middle of the mesh, so that meshes far from their origin keep the precision of 32
    /// bits.
    pub(crate) mesh_from_vertices: Transform,
    /// Keeps the address from being used by another mesh.
    _mesh: Arc<Mesh>,
}

/// All meshes that have been drawn.
#[derive(Default)]
pub(crate) struct Meshes {
    pub(crate) pages: Vec<Page>,
    by_address: HashMap<usize, Resident>,
}

impl Meshes {
    /// Returns a mesh, uploaded if it is new.
    pub(crate) fn get(&mut self, device: &Device, queue: &Queue, mesh: &Arc<Mesh>) -> &Resident {
        let address = Arc::as_ptr(mesh).addr();
        if !self.by_address.contains_key(&address) {
            let pieces = self.upload(device, queue, mesh);
            let resident = Resident {
                pieces,
                mesh_from_vertices: Transform::translation(middle(mesh)),
                _mesh: Arc::clone(mesh),
            };
            self.by_address.insert(address, resident);
        }
        &self.by_address[&address]
    }

    /// Returns the bytes on the GPU.
    pub(crate) fn bytes(&self) -> u64 {
        self.pages
            .iter()
            .map(|page| page.vertices.size() + page.indices.size())
            .sum()
    }

    fn upload(&mut self, device: &Device, queue: &Queue, mesh: &Mesh) -> Vec<Piece> {
        let indices: Vec<u32> = mesh.triangle_indices().collect();
        let mut pieces = Vec::new();
        let clusters = mesh.clusters();
        let mut first = 0;
        while first < clusters.len() {
            // As many clusters as fit into a page. One always does.
            let start = (clusters[first].positions.start, mesh.cluster_indices(first).start);
            let fits = |&cluster: &usize| {
                let end = (clusters[cluster].positions.end, mesh.cluster_indices(cluster).end);
                (end.0 - start.0) as usize <= VERTICES && (end.1 - start.1) as usize <= INDICES
            };
            let last = (first..clusters.len()).take_while(fits).last().unwrap_or(first);
            let positions = start.0..clusters[last].positions.end;
            let of_mesh = start.1..mesh.cluster_indices(last).end;
            first = last + 1;
            if of_mesh.is_empty() {
                continue;
            }
            let number = self.page_for(device, positions.len(), of_mesh.len());
            let page = &mut self.pages[number];
            let vertices: Vec<Vertex> = positions.clone().map(|at| vertex(mesh, at as usize)).collect();
            let base = page.vertices_used as u32;
            let moved: Vec<u32> = indices[of_mesh.start as usize..of_mesh.end as usize]
                .iter()
                .map(|index| index - positions.start + base)
                .collect();
            let at = |used: usize, size: usize| (used * size) as u64;
            queue.write_buffer(
                &page.vertices,
                at(page.vertices_used, size_of::<Vertex>()),
                bytemuck::cast_slice(&vertices),
            );
            queue.write_buffer(
                &page.indices,
                at(page.indices_used, size_of::<u32>()),
                bytemuck::cast_slice(&moved),
            );
            pieces.push(Piece {
                page: number as u32,
                start: page.indices_used as u32,
                of_mesh,
            });
            page.vertices_used += vertices.len();
            page.indices_used += moved.len();
        }
        pieces
    }

    /// Returns a page with room for some vertices and indices.
    fn page_for(&mut self, device: &Device, vertices: usize, indices: usize) -> usize {
        let has_room = |page: &Page| {
            ((page.vertices_used + vertices) * size_of::<Vertex>()) as u64 <= page.vertices.size()
                && ((page.indices_used + indices) * size_of::<u32>()) as u64 <= page.indices.size()
        };
        // Only the last pages: earlier ones are nearly full.
        let recent = self.pages.len().saturating_sub(4);
        if let Some(found) = self.pages[recent..].iter().position(has_room) {
            return recent + found;
        }
        let buffer = |label, size: usize, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size as u64,
                usage: usage | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        self.pages.push(Page {
            vertices: buffer(
                "vertices",
                vertices.max(VERTICES) * size_of::<Vertex>(),
                BufferUsages::VERTEX,
            ),
            indices: buffer(
                "indices",
                indices.max(INDICES) * size_of::<u32>(),
                BufferUsages::INDEX,
            ),
            vertices_used: 0,
            indices_used: 0,
        });
        self.pages.len() - 1
    }
}

fn middle(mesh: &Mesh) -> [f32; 3] {
    let bounds = mesh.bounds();
    if bounds.is_empty() {
        [0.0; 3]
    } else {
        bounds.center()
    }
}

fn vertex(mesh: &Mesh, at: usize) -> Vertex {
    let normal = mesh.normals().get(at).copied().unwrap_or_default();
    let [x, y, z] = normal.map(|value| (value.clamp(-1.0, 1.0) * 32767.0).round() as i16);
    let color = mesh.colors().get(at).copied().unwrap_or([1.0; 4]);
    let (position, middle) = (mesh.positions()[at], middle(mesh));
    Vertex {
        position: [0, 1, 2].map(|axis| position[axis] - middle[axis]),
        normal: [x, y, z, 0],
        uv: mesh.texture().get(at).copied().unwrap_or_default(),
        color: color.map(|value| (value.clamp(0.0, 1.0) * 65535.0).round() as u16),
    }
}
