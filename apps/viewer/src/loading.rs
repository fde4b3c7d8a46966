//! Files that are being opened: on a thread of their own, where there are threads.

use crate::path;
use crate::world::{MEMORY, World};
use anyhow::{Context, Result, anyhow};
use eframe::egui::DroppedFileHandle;
use enfilade::Camera;
use std::path::Path;
use web_time::Instant;

/// What a file holds.
pub enum Opened {
    /// A scene.
    Scene(Box<World>),
    /// A camera path.
    Path(Vec<Camera>),
}

/// A file that is being opened.
pub struct Loading {
    name: String,
    start: Instant,
    /// What is done now.
    stage: &'static str,
    #[cfg(not(target_arch = "wasm32"))]
    messages: std::sync::mpsc::Receiver<Message>,
    #[cfg(target_arch = "wasm32")]
    work: Work,
}

/// What the thread that opens a file says.
#[cfg(not(target_arch = "wasm32"))]
enum Message {
    /// It begins with this.
    Stage(&'static str),
    /// It has ended.
    Done(Result<Opened>),
}

/// What is left to do without threads.
#[cfg(target_arch = "wasm32")]
enum Work {
    /// A built-in scene. Some frames pass before, so that the message is seen.
    BuiltIn(u32),
    /// The file is on its way.
    Bytes(Arrived, u32),
}

#[cfg(target_arch = "wasm32")]
type Arrived = std::rc::Rc<std::cell::RefCell<Option<Result<Vec<u8>, String>>>>;

impl Loading {
    /// Opens a file, or a built-in scene by `@NAME`.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn file(name: &str) -> Loading {
        let (sender, messages) = std::sync::mpsc::channel();
        let file = name.to_owned();
        std::thread::spawn(move || {
            let say = |stage| {
                // An error means that another file was wanted meanwhile.
                let _ = sender.send(Message::Stage(stage));
            };
            let opened = open(&file, &say);
            let _ = sender.send(Message::Done(opened));
        });
        Loading {
            name: name.to_owned(),
            start: Instant::now(),
            stage: "opening it",
            messages,
        }
    }

    /// Opens a file that was dropped on the window.
    #[cfg(not(target_arch = "wasm32"))]
    #[expect(clippy::needless_pass_by_value, reason = "the same as on the web")]
    pub fn dropped(file: DroppedFileHandle) -> Loading {
        Loading::file(&file.path().to_string_lossy())
    }

    /// Returns what the file holds, once it is open.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn poll(&mut self) -> Option<Result<Opened>> {
        use std::sync::mpsc::TryRecvError;
        loop {
            match self.messages.try_recv() {
                Ok(Message::Stage(stage)) => self.stage = stage,
                Ok(Message::Done(result)) => return Some(result),
                Err(TryRecvError::Empty) => return None,
                Err(TryRecvError::Disconnected) => {
                    let name = &self.name;
                    return Some(Err(anyhow!(
                        "{name}: opening it failed unexpectedly; please report the file"
                    )));
                }
            }
        }
    }

    /// Opens a built-in scene by `@NAME`.
    #[cfg(target_arch = "wasm32")]
    pub fn file(name: &str) -> Loading {
        Loading {
            name: name.to_owned(),
            start: Instant::now(),
            stage: "building the scene",
            work: Work::BuiltIn(2),
        }
    }

    /// Opens a file that was dropped on the page.
    #[cfg(target_arch = "wasm32")]
    pub fn dropped(file: DroppedFileHandle) -> Loading {
        let name = file.path().to_string_lossy().into_owned();
        Loading::arriving(&name, async move { file.bytes_async().await })
    }

    /// Opens a file whose bytes arrive.
    #[cfg(target_arch = "wasm32")]
    pub fn arriving(name: &str, bytes: impl Future<Output = Result<Vec<u8>, String>> + 'static) -> Loading {
        let arrived = Arrived::default();
        let to = std::rc::Rc::clone(&arrived);
        wasm_bindgen_futures::spawn_local(async move {
            let bytes = bytes.await;
            *to.borrow_mut() = Some(bytes);
        });
        Loading {
            name: name.to_owned(),
            start: Instant::now(),
            stage: "reading the file",
            work: Work::Bytes(arrived, 2),
        }
    }

    /// Returns what the file holds, once it is open.
    #[cfg(target_arch = "wasm32")]
    pub fn poll(&mut self) -> Option<Result<Opened>> {
        let (Work::BuiltIn(frames) | Work::Bytes(_, frames)) = &mut self.work;
        if *frames > 0 {
            *frames -= 1;
            return None;
        }
        match &self.work {
            Work::BuiltIn(_) => Some(open(&self.name, &|_| ())),
            Work::Bytes(arrived, _) => {
                let bytes = arrived.borrow_mut().take()?;
                Some(
                    bytes
                        .map_err(|why| anyhow!("{}: {why}", self.name))
                        .and_then(|bytes| read(&self.name, &bytes)),
                )
            }
        }
    }

    /// Returns what is being opened.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Says what is done now, and for how long the file has been opened.
    pub fn progress(&self) -> String {
        let seconds = self.start.elapsed().as_secs_f64();
        format!("{}: {} … {seconds:.0} s", self.name, self.stage)
    }
}

fn open(name: &str, say: &dyn Fn(&'static str)) -> Result<Opened> {
    if is_path(name) {
        return read(name, &enfilade_import::file_bytes(Path::new(name), MEMORY)?);
    }
    Ok(Opened::Scene(Box::new(World::open_with(name, say)?)))
}

fn read(name: &str, bytes: &[u8]) -> Result<Opened> {
    if is_path(name) {
        let text = String::from_utf8_lossy(bytes);
        return Ok(Opened::Path(path::read(&text).with_context(|| name.to_owned())?));
    }
    Ok(Opened::Scene(Box::new(World::of_bytes(name, bytes)?)))
}

fn is_path(name: &str) -> bool {
    name.ends_with(".jsonl")
}
