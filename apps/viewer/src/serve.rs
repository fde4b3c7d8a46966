//! Serves the web page of the viewer, with a scene, to this machine only.

use anyhow::{Context, Result};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// Files of the page.
const FILES: [(&str, &str); 4] = [
    ("index.html", "text/html; charset=utf-8"),
    ("page.js", "text/javascript"),
    ("viewer.js", "text/javascript"),
    ("viewer_bg.wasm", "application/wasm"),
];

/// A page and its scene.
pub struct Server {
    listener: TcpListener,
    folder: PathBuf,
    scene: Option<Arc<Vec<u8>>>,
    /// The address to open.
    pub address: String,
}

impl Server {
    /// Listens on 127.0.0.1. `port` 0 chooses a free one.
    ///
    /// # Errors
    /// If the page has not been built, the scene cannot be read, or the port is taken.
    pub fn new(scene: &str, port: u16) -> Result<Server> {
        let folder = folder()?;
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))
            .with_context(|| format!("cannot listen on port {port} of 127.0.0.1"))?;
        let port = listener.local_addr()?.port();
        let (scene, query) = match scene.starts_with('@') {
            true => (None, format!("?scene={scene}")),
            false => {
                let path = Path::new(scene);
                let name = path
                    .file_name()
                    .context("the scene has no file name")?
                    .to_string_lossy();
                let bytes = in_one_file(path)?;
                // The reader detects the format from the content; the name is for display.
                (Some(Arc::new(bytes)), format!("?scene=scene/{}", escaped(&name)))
            }
        };
        Ok(Server {
            listener,
            folder,
            scene,
            address: format!("http://127.0.0.1:{port}/{query}"),
        })
    }

    /// Answers requests until the process ends.
    ///
    /// # Errors
    /// If the system refuses connections.
    pub fn run(&self) -> Result<()> {
        for stream in self.listener.incoming() {
            let (stream, folder, scene) = (stream?, self.folder.clone(), self.scene.clone());
            std::thread::spawn(move || {
                // A browser that hangs up misses its own answer only.
                let _ = answer(&stream, &folder, scene.as_ref());
            });
        }
        Ok(())
    }
}

/// Returns the folder of the page.
fn folder() -> Result<PathBuf> {
    let program = std::env::current_exe().context("cannot tell where this program is")?;
    // Beside the program, or beside the folder of the build profile.
    let folders = program
        .ancestors()
        .skip(1)
        .take(2)
        .map(|folder| folder.join("viewer-web"));
    let is_whole = |folder: &PathBuf| FILES.iter().all(|(name, _)| folder.join(name).is_file());
    let found = folders.into_iter().find(is_whole);
    found.with_context(|| {
        format!(
            "the web page is not there: no folder viewer-web with {} beside {}; `cargo xtask viewer --web` builds it",
            FILES.map(|(name, _)| name).join(", "),
            program.display()
        )
    })
}

fn answer(mut stream: &TcpStream, folder: &Path, scene: Option<&Arc<Vec<u8>>>) -> Result<()> {
    /// Longest request that is read.
    const LONGEST: u64 = 1 << 14;
    stream.set_read_timeout(Some(Duration::from_secs(10)))?;
    let mut lines = BufReader::new(stream.take(LONGEST)).lines();
    let first = lines.next().context("an empty request")??;
    // A page of another site must not read the scene through a name that leads here.
    let mut is_here = false;
    for line in lines {
        let line = line?;
        if line.is_empty() {
            break;
        }
        if let Some((name, host)) = line.split_once(':')
            && name.eq_ignore_ascii_case("host")
        {
            let host = host.trim();
            is_here = ["127.0.0.1", "localhost"]
                .iter()
                .any(|own| host == *own || host.starts_with(&format!("{own}:")));
        }
    }
    let mut words = first.split(' ');
    let (method, path) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let path = path.split('?').next().unwrap_or_default().trim_start_matches('/');
    let name = if path.is_empty() { "index.html" } else { path };
    let known = FILES.iter().find(|(file, _)| *file == name);
    let (status, kind, body) = match (method, known, scene) {
        _ if !is_here => ("403 Forbidden", "text/plain", b"for 127.0.0.1 only".to_vec()),
        ("GET" | "HEAD", Some((file, kind)), _) => ("200 OK", *kind, std::fs::read(folder.join(file))?),
        ("GET" | "HEAD", None, Some(bytes)) if name.starts_with("scene/") => {
            ("200 OK", "application/octet-stream", bytes.to_vec())
        }
        _ => ("404 Not Found", "text/plain", b"there is no such file".to_vec()),
    };
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
         Cross-Origin-Opener-Policy: same-origin\r\nConnection: close\r\n\r\n",
        body.len()
    )?;
    if method != "HEAD" {
        stream.write_all(&body)?;
    }
    Ok(stream.flush()?)
}

/// Reads a file. A glTF file takes its buffers and images along, because a page reads one file.
fn in_one_file(path: &Path) -> Result<Vec<u8>> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let is_json = path
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("gltf"));
    let parsed = is_json
        .then(|| serde_json::from_slice::<Value>(&bytes).ok())
        .flatten();
    let Some(mut file) = parsed else { return Ok(bytes) };
    let folder = path.parent().unwrap_or(Path::new("."));
    for kind in ["buffers", "images"] {
        let list = file.get_mut(kind).and_then(Value::as_array_mut);
        for entry in list.into_iter().flatten() {
            let Some(uri) = entry.get("uri").and_then(Value::as_str) else {
                continue;
            };
            if uri.starts_with("data:") {
                continue;
            }
            let beside = folder.join(unescaped(uri));
            let bytes =
                std::fs::read(&beside).with_context(|| format!("cannot read {}", beside.display()))?;
            let data = format!("data:application/octet-stream;base64,{}", STANDARD.encode(bytes));
            entry["uri"] = Value::String(data);
        }
    }
    Ok(serde_json::to_vec(&file)?)
}

/// Returns a file name for an address.
fn escaped(name: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte);
    let byte = |byte: u8| match plain(byte) {
        true => char::from(byte).to_string(),
        false => format!("%{byte:02X}"),
    };
    name.bytes().map(byte).collect()
}

/// Returns a name from an address.
fn unescaped(uri: &str) -> String {
    let bytes = uri.as_bytes();
    let (mut name, mut at) = (Vec::new(), 0);
    while let Some(&byte) = bytes.get(at) {
        let code = (byte == b'%').then(|| uri.get(at + 1..at + 3)).flatten();
        match code.and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(byte) => {
                name.push(byte);
                at += 3;
            }
            None => {
                name.push(byte);
                at += 1;
            }
        }
    }
    String::from_utf8_lossy(&name).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_through_addresses_unchanged() {
        for name in ["a b.glb", "Größe%20.gltf", "50%.obj", "plain.bsp"] {
            assert_eq!(unescaped(&escaped(name)), name);
        }
        assert_eq!(unescaped("50%"), "50%");
    }

    #[test]
    fn a_gltf_file_takes_its_buffers_along() {
        let folder = std::env::temp_dir().join("enfilade-in-one-file");
        std::fs::create_dir_all(&folder).expect("a folder");
        std::fs::write(folder.join("some data.bin"), [1, 2, 3]).expect("written");
        let path = folder.join("a.gltf");
        std::fs::write(&path, r#"{"buffers":[{"uri":"some%20data.bin","byteLength":3}]}"#).expect("written");
        let file: Value = serde_json::from_slice(&in_one_file(&path).expect("it is there")).expect("JSON");
        let uri = file["buffers"][0]["uri"].as_str();
        assert_eq!(uri, Some("data:application/octet-stream;base64,AQID"));
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn other_files_and_other_hosts_are_refused() {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        let port = listener.local_addr().expect("bound").port();
        let ask = |request: &str| {
            let mut client = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).expect("it listens");
            client.write_all(request.as_bytes()).expect("sent");
            let (server, _) = listener.accept().expect("a request");
            let scene = Arc::new(b"a scene".to_vec());
            answer(&server, Path::new("."), Some(&scene)).expect("answered");
            drop(server);
            let mut text = String::new();
            client.read_to_string(&mut text).expect("an answer");
            text
        };
        let own = ask("GET /scene/a.glb HTTP/1.1\r\nHost: 127.0.0.1:80\r\n\r\n");
        assert!(
            own.starts_with("HTTP/1.1 200") && own.ends_with("a scene"),
            "{own}"
        );
        let other = ask("GET /../Cargo.toml HTTP/1.1\r\nHost: localhost\r\n\r\n");
        assert!(other.starts_with("HTTP/1.1 404"), "{other}");
        let foreign = ask("GET /scene/a.glb HTTP/1.1\r\nHost: example.org\r\n\r\n");
        assert!(foreign.starts_with("HTTP/1.1 403"), "{foreign}");
    }
}
