//! Records what a traversal tests and emits, and ends it after a number of steps (feature `steps`).

use super::Visit;
use crate::faces::{FaceSource, Faces};
use crate::geom::Aabb;
use crate::geometry::Geometry;
use crate::ids::ItemIndex;
use crate::view::passage::Passage;
use crate::view::region::{Region, Visibility};
use crate::view::screen_map::ScreenMap;
use crate::view::step_log::{LookStep, StepLog};

/// Forwards a traversal to another receiver, and records its steps.
pub(crate) struct Recorder<'a, V> {
    inner: &'a mut V,
    log: &'a mut StepLog,
}

impl<'a, V: Visit> Recorder<'a, V> {
    pub(crate) fn new(inner: &'a mut V, log: &'a mut StepLog) -> Recorder<'a, V> {
        Recorder { inner, log }
    }

    fn record(&mut self, region: &Region, visibility: Visibility) -> Visibility {
        self.log.steps.push(LookStep::Box {
            passage: self.log.passage(),
            rect: region.rect,
            rev_depth: region.nearest,
            visibility,
        });
        visibility
    }

    fn record_cluster(&mut self, item: ItemIndex, cluster: Option<u32>) {
        self.log.steps.push(LookStep::Cluster {
            passage: self.log.passage(),
            item,
            cluster,
        });
    }

    fn record_faces(&mut self, faces: &Faces) {
        match faces.source {
            FaceSource::Item(item, cluster) => self.record_cluster(item, Some(cluster)),
            FaceSource::Opening(opening) => self.log.steps.push(LookStep::Opening {
                passage: self.log.passage(),
                opening,
            }),
        }
    }
}

impl<V: Visit> Visit for Recorder<'_, V> {
    fn enter(&mut self, region: &Region) -> Visibility {
        if self.log.is_full() {
            return Visibility::Hidden;
        }
        let visibility = self.inner.enter(region);
        self.record(region, visibility)
    }

    fn enter_box(&mut self, passage: &Passage, screen_from_local: &ScreenMap, bounds: &Aabb) -> Visibility {
        if self.log.is_full() {
            return Visibility::Hidden;
        }
        let visibility = self.inner.enter_box(passage, screen_from_local, bounds);
        match Region::of(passage, screen_from_local, bounds) {
            Some(region) => self.record(&region, visibility),
            None => visibility,
        }
    }

    fn go_within(&mut self) {
        self.inner.go_within();
    }

    fn go_back(&mut self) {
        self.inner.go_back();
    }

    fn are_enough(&mut self, item: ItemIndex, node: u32, region: &Region) -> bool {
        let enough = self.log.is_full() || self.inner.are_enough(item, node, region);
        if enough && !self.log.is_full() {
            self.record_cluster(item, None);
        }
        enough
    }

    fn first_time(&mut self, item: ItemIndex) -> bool {
        !self.log.is_full() && self.inner.first_time(item)
    }

    fn faces(&mut self, faces: &Faces) {
        if !self.log.is_full() {
            self.inner.faces(faces);
            self.record_faces(faces);
        }
    }

    fn faces_within(&mut self, faces: &Faces, region: &Region) {
        if !self.log.is_full() {
            self.inner.faces_within(faces, region);
            self.record_faces(faces);
        }
    }

    fn cluster(&mut self, geometry: &Geometry, item: ItemIndex, cluster: u32, screen_from_item: &ScreenMap) {
        if !self.log.is_full() {
            self.inner.cluster(geometry, item, cluster, screen_from_item);
            self.record_cluster(item, Some(cluster));
        }
    }

    fn whole(&mut self, geometry: &Geometry, item: ItemIndex, screen_from_item: &ScreenMap) {
        if !self.log.is_full() {
            self.inner.whole(geometry, item, screen_from_item);
            self.record_cluster(item, None);
        }
    }
}
