//! Serves the web page of the viewer, with a scene, to the browser of this machine only.
//!
//! Who may read the scene: whoever knows the address, because it holds a random token, and no page of another site, because
//! `Host`, `Origin` and `Cross-Origin-Resource-Policy` keep those out.
//! Cost: one thread per request, at most [`CONNECTIONS`]; all send the same buffers, in pieces with a timeout.

use crate::world::{MEMORY, options};
use anyhow::{Context, Result, anyhow};
use enfilade_import::{bake, file_bytes, read};
use std::io::{Cursor, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Files of the page.
const FILES: [(&str, &str); 4] = [
    ("index.html", "text/html; charset=utf-8"),
    ("page.js", "text/javascript"),
    ("viewer.js", "text/javascript"),
    ("viewer_bg.wasm", "application/wasm"),
];

/// Requests that are answered at once; a browser makes six. Further ones are refused.
const CONNECTIONS: usize = 64;

/// Time in which a request must arrive, and in which each piece of an answer must leave.
const PATIENCE: Duration = Duration::from_secs(10);

/// A page and its scene.
pub struct Server {
    listener: TcpListener,
    site: Arc<Site>,
    /// The address to open.
    pub address: String,
}

/// What is served: all that requests share.
struct Site {
    port: u16,
    /// First part of all paths.
    token: String,
    /// The bytes of [`FILES`].
    page: [Vec<u8>; FILES.len()],
    scene: Option<Vec<u8>>,
    open: AtomicUsize,
}

impl Server {
    /// Listens on 127.0.0.1. `port` 0 chooses a free one.
    ///
    /// # Errors
    /// If the page has not been built, the scene cannot be read, or the port is taken.
    pub fn new(scene: &str, port: u16) -> Result<Server> {
        let folder = folder()?;
        let mut page: [Vec<u8>; FILES.len()] = Default::default();
        for (bytes, (name, _)) in page.iter_mut().zip(FILES) {
            *bytes = file_bytes(&folder.join(name), MEMORY)?;
        }
        let (scene, query) = match scene.starts_with('@') {
            true => (None, format!("?scene={scene}")),
            false => {
                let path = Path::new(scene);
                let name = path.file_name().context("the scene has no file name")?;
                // The reader detects the format from the content; the name is for display.
                let query = format!("?scene=scene/{}", escaped(&name.to_string_lossy()));
                (Some(in_one_file(path)?), query)
            }
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))
            .with_context(|| format!("cannot listen on port {port} of 127.0.0.1"))?;
        let port = listener.local_addr()?.port();
        let token = token()?;
        Ok(Server {
            listener,
            address: format!("http://127.0.0.1:{port}/{token}/{query}"),
            site: Arc::new(Site {
                port,
                token,
                page,
                scene,
                open: AtomicUsize::new(0),
            }),
        })
    }

    /// Answers requests until the process ends.
    ///
    /// # Errors
    /// If the socket is lost.
    pub fn run(&self) -> Result<()> {
        loop {
            match self.listener.accept() {
                Ok((stream, _)) => self.site.take(stream),
                // A client that hung up before it was accepted, or none of the handles of this process is free.
                Err(why) if why.kind() != ErrorKind::InvalidInput => {
                    std::thread::sleep(Duration::from_millis(50));
                }
                Err(why) => return Err(why).context("cannot accept connections"),
            }
        }
    }
}

/// Returns 128 random bits as text.
fn token() -> Result<String> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(|why| anyhow!("the system gives no random numbers: {why}"))?;
    Ok(format!("{:032x}", u128::from_le_bytes(bytes)))
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

/// Returns a scene as one file, because that is what a page reads: the file itself, or, if it names others, a baked scene.
fn in_one_file(path: &Path) -> Result<Vec<u8>> {
    // By the reader alone, whose rules decide which files a scene may name.
    let import = read(path, &options())?;
    if import.files.is_empty() {
        return Ok(file_bytes(path, MEMORY)?);
    }
    let mut baked = Cursor::new(Vec::new());
    bake(&import, &mut baked).with_context(|| path.display().to_string())?;
    Ok(baked.into_inner())
}

/// An answer.
struct Answer<'a> {
    status: &'static str,
    kind: &'static str,
    body: &'a [u8],
}

impl Site {
    /// Answers a request on a thread of its own, or refuses it if too many are open.
    fn take(self: &Arc<Site>, stream: TcpStream) {
        if self.open.fetch_add(1, Ordering::AcqRel) >= CONNECTIONS {
            self.open.fetch_sub(1, Ordering::AcqRel);
            return;
        }
        let site = Arc::clone(self);
        let answers = std::thread::Builder::new().spawn(move || {
            // A browser that hangs up misses its own answer only.
            let _ = site.serve(&stream);
            site.open.fetch_sub(1, Ordering::AcqRel);
        });
        if answers.is_err() {
            self.open.fetch_sub(1, Ordering::AcqRel);
        }
    }

    /// Reads a request and sends the answer.
    fn serve(&self, mut stream: &TcpStream) -> Result<()> {
        /// Longest request that is read, in bytes.
        const LONGEST: usize = 1 << 14;
        /// Bytes that a client must take within [`PATIENCE`].
        const PIECE: usize = 1 << 20;
        let deadline = Instant::now() + PATIENCE;
        let mut request = Vec::new();
        while !request.windows(4).any(|end| end == b"\r\n\r\n") {
            let left = deadline.saturating_duration_since(Instant::now());
            stream.set_read_timeout(Some(left.max(Duration::from_millis(1))))?;
            let mut piece = [0; 1 << 12];
            let length = stream.read(&mut piece)?;
            request.extend_from_slice(&piece[..length]);
            if length == 0 || request.len() > LONGEST || left.is_zero() {
                return Ok(());
            }
        }
        let (answer, is_head) = self.answer(&request);
        let head = format!(
            "HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\nCache-Control: no-store\r\n\
             Cross-Origin-Opener-Policy: same-origin\r\nCross-Origin-Resource-Policy: same-origin\r\n\
             Referrer-Policy: no-referrer\r\nX-Content-Type-Options: nosniff\r\nConnection: close\r\n\r\n",
            answer.status,
            answer.kind,
            answer.body.len()
        );
        let body = if is_head { &[] } else { answer.body };
        for mut piece in std::iter::once(head.as_bytes()).chain(body.chunks(PIECE)) {
            let deadline = Instant::now() + PATIENCE;
            while !piece.is_empty() {
                let left = deadline.saturating_duration_since(Instant::now());
                stream.set_write_timeout(Some(left.max(Duration::from_millis(1))))?;
                match stream.write(piece)? {
                    _ if left.is_zero() => return Ok(()),
                    0 => return Ok(()),
                    length => piece = &piece[length..],
                }
            }
        }
        Ok(())
    }

    /// Returns the answer to a request, and whether it is wanted without its body.
    fn answer(&self, request: &[u8]) -> (Answer<'_>, bool) {
        let refusal = |status, why: &'static str| Answer {
            status,
            kind: "text/plain",
            body: why.as_bytes(),
        };
        let mut headers = [httparse::EMPTY_HEADER; 64];
        let mut parsed = httparse::Request::new(&mut headers);
        let is_whole = parsed.parse(request).is_ok_and(|status| status.is_complete());
        let (Some(method), Some(path), true) = (parsed.method, parsed.path, is_whole) else {
            return (refusal("400 Bad Request", "not a request of HTTP/1.1"), false);
        };
        let values = |name: &'static str| {
            let named = parsed
                .headers
                .iter()
                .filter(move |header| header.name.eq_ignore_ascii_case(name));
            named.map(|header| String::from_utf8_lossy(header.value))
        };
        // A page of another site must not read the scene, neither through a name that leads here nor across origins.
        let own = ["127.0.0.1", "localhost"].map(|name| [name.to_owned(), format!("{name}:{}", self.port)]);
        let is_own = |host: &str| own.as_flattened().iter().any(|own| own == host);
        let is_here = values("host").count() == 1
            && values("host").all(|host| is_own(&host))
            && values("origin").all(|origin| origin.strip_prefix("http://").is_some_and(is_own));
        if !is_here {
            return (refusal("403 Forbidden", "for pages of this server only"), false);
        }
        let path = path.split('?').next().unwrap_or_default();
        let inside = path
            .strip_prefix('/')
            .and_then(|path| path.strip_prefix(&*self.token));
        let name = match inside.and_then(|path| path.strip_prefix('/')) {
            Some("") => Some("index.html"),
            name => name,
        };
        let file = |(status, kind, body)| Answer { status, kind, body };
        let known = FILES
            .iter()
            .zip(&self.page)
            .find(|((file, _), _)| Some(*file) == name);
        let answer = match (method, known, &self.scene) {
            ("GET" | "HEAD", Some(((_, kind), bytes)), _) => file(("200 OK", kind, bytes)),
            ("GET" | "HEAD", None, Some(bytes)) if name.is_some_and(|name| name.starts_with("scene/")) => {
                file(("200 OK", "application/octet-stream", bytes))
            }
            _ => refusal("404 Not Found", "there is no such file"),
        };
        (answer, method == "HEAD")
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use enfilade_import::{ReadOptions, read_bytes};
    use serde_json::json;

    const TOKEN: &str = "0123456789abcdef";

    fn server(scene: Vec<u8>) -> Server {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).expect("a port");
        let port = listener.local_addr().expect("bound").port();
        Server {
            listener,
            address: format!("127.0.0.1:{port}"),
            site: Arc::new(Site {
                port,
                token: TOKEN.to_owned(),
                page: FILES.map(|(name, _)| name.as_bytes().to_vec()),
                scene: Some(scene),
                open: AtomicUsize::new(0),
            }),
        }
    }

    #[test]
    fn only_the_page_itself_and_who_knows_the_address_get_the_scene() {
        let server = server(b"a scene".to_vec());
        let port = server.site.port;
        let status = |path: &str, headers: &str| {
            let request =
                format!("GET {path} HTTP/1.1\r\n{headers}\r\n\r\n").replace("PORT", &port.to_string());
            server.site.answer(request.as_bytes()).0.status[..3].to_owned()
        };
        let scene = format!("/{TOKEN}/scene/a.glb");
        for (headers, expected) in [
            ("Host: 127.0.0.1:PORT", "200"),
            ("host: localhost:PORT\r\norigin: http://localhost:PORT", "200"),
            ("Host: localhost", "200"),
            ("Host: 127.0.0.1:1", "403"),
            ("Host: example.org", "403"),
            ("Host: localhost.example.org", "403"),
            ("Host: localhost\r\nHost: example.org", "403"),
            ("Accept: */*", "403"),
            ("Host: localhost:PORT\r\nOrigin: http://example.org", "403"),
            ("Host: localhost:PORT\r\nOrigin: null", "403"),
            ("Host: localhost:PORT\r\nOrigin: https://localhost:PORT", "403"),
        ] {
            assert_eq!(status(&scene, headers), expected, "{headers}");
        }
        for (path, expected) in [
            (format!("/{TOKEN}/"), "200"),
            (format!("/{TOKEN}/?scene=scene/a.glb"), "200"),
            (format!("/{TOKEN}/viewer.js"), "200"),
            (format!("/{TOKEN}/../Cargo.toml"), "404"),
            (format!("/{TOKEN}/scene.glb"), "404"),
            (format!("/{TOKEN}"), "404"),
            (format!("/{TOKEN}x/"), "404"),
            ("/".to_owned(), "404"),
            ("/scene/a.glb".to_owned(), "404"),
            ("/viewer.js".to_owned(), "404"),
        ] {
            assert_eq!(status(&path, "Host: localhost"), expected, "{path}");
        }
        let [one, other] = [token(), token()].map(|token| token.expect("random"));
        assert!(one != other && one.len() == 32);
    }

    /// Sends a request for the scene.
    fn ask(server: &str) -> TcpStream {
        let mut client = TcpStream::connect(server).expect("it listens");
        let request = format!("GET /{TOKEN}/scene/a HTTP/1.1\r\nHost: localhost\r\n\r\n");
        client.write_all(request.as_bytes()).expect("sent");
        client
    }

    fn resident_bytes() -> u64 {
        let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
        let kib = line.and_then(|line| line.trim().strip_suffix(" kB")?.parse::<u64>().ok());
        1024 * kib.expect("a number")
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn clients_that_do_not_read_share_one_scene_and_stop_no_other() {
        const SCENE: usize = 1 << 26;
        let server = server(vec![7; SCENE]);
        let address = server.address.clone();
        std::thread::spawn(move || server.run());
        let before = resident_bytes();
        let mut idle: Vec<TcpStream> = (0..40).map(|_| ask(&address)).collect();
        std::thread::sleep(Duration::from_secs(1));
        let grown = resident_bytes().saturating_sub(before);
        assert!(
            grown < SCENE as u64 / 2,
            "{grown} bytes for clients that read nothing"
        );
        let mut answer = Vec::new();
        ask(&address).read_to_end(&mut answer).expect("an answer");
        assert!(answer.starts_with(b"HTTP/1.1 200") && answer.len() > SCENE);
        // More than are answered at once, and some that ask for nothing.
        idle.extend((0..60).map(|_| ask(&address)));
        idle.extend((0..200).map(|_| TcpStream::connect(&address).expect("it listens")));
        std::thread::sleep(Duration::from_millis(200));
        drop(idle);
        std::thread::sleep(Duration::from_secs(1));
        let mut answer = Vec::new();
        ask(&address).read_to_end(&mut answer).expect("an answer");
        assert!(answer.len() > SCENE, "the server goes on");
    }

    /// A triangle in a buffer, with an image.
    fn triangle(buffer: &str, image: &str) -> String {
        let triangle = json!({
            "asset": { "version": "2.0" },
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0, "name": "leaf" }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "material": 0 }] }],
            "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
            "textures": [{ "source": 0 }],
            "images": [{ "uri": image }],
            "accessors": [{ "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
                "min": [0, 0, 0], "max": [1, 1, 0] },
                { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC2" }],
            "bufferViews": [{ "buffer": 0, "byteLength": 36 }],
            "buffers": [{ "uri": buffer, "byteLength": 36 }],
        });
        triangle.to_string()
    }

    fn corners() -> Vec<u8> {
        let corners = [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
        corners.iter().flat_map(|number| number.to_le_bytes()).collect()
    }

    /// One red texel.
    fn picture() -> Vec<u8> {
        let mut png = Cursor::new(Vec::new());
        let red = image::RgbaImage::from_pixel(1, 1, image::Rgba([255, 0, 0, 255]));
        red.write_to(&mut png, image::ImageFormat::Png).expect("written");
        png.into_inner()
    }

    #[test]
    fn a_scene_takes_its_files_along_and_none_that_it_must_not_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let scene = folder.path().join("scene");
        std::fs::create_dir(&scene).expect("made");
        for (path, bytes) in [
            ("scene/some data.bin", corners()),
            ("scene/red.png", picture()),
            ("secret.bin", corners()),
            ("secret.png", picture()),
        ] {
            std::fs::write(folder.path().join(path), bytes).expect("written");
        }
        let path = scene.join("a.gltf");
        let in_one_file = |text: String| {
            std::fs::write(&path, text).expect("written");
            super::in_one_file(&path)
        };
        let whole = in_one_file(triangle("some%20data.bin", "red.png")).expect("beside it");
        let read = |bytes: &[u8]| read_bytes(bytes, None, &ReadOptions::default()).expect("a scene");
        let import = read(&whole);
        assert!(
            import.files.is_empty() && import.warnings.is_empty(),
            "{:?} {:?}",
            import.files,
            import.warnings
        );
        assert_eq!(import.rooms[0].geometry.items().len(), 1);
        assert_eq!(import.rooms[0].geometry.textures().len(), 1);
        let secret = folder.path().join("secret.bin");
        for uri in [
            "../secret.bin",
            "%2e%2e/secret.bin",
            "/dev/zero",
            &secret.to_string_lossy(),
        ] {
            let why = in_one_file(triangle(uri, "red.png")).expect_err("a refusal");
            assert!(
                format!("{why:#}").contains("leads out of the file's folder"),
                "{why:#}"
            );
            let without =
                in_one_file(triangle("some%20data.bin", &uri.replace(".bin", ".png"))).expect("grey");
            assert!(!without.windows(4).any(|bytes| bytes == [255, 0, 0, 255]));
            assert_eq!(read(&without).warnings.len(), 1, "the image is missing");
        }
        #[cfg(unix)]
        {
            let pipe = scene.join("pipe.bin");
            let made = std::process::Command::new("mkfifo").arg(&pipe).status();
            assert!(made.expect("mkfifo").success());
            let why = in_one_file(triangle("pipe.bin", "red.png")).expect_err("a refusal");
            assert!(format!("{why:#}").contains("a pipe or a device"), "{why:#}");
            let why = super::in_one_file(&pipe).expect_err("a refusal");
            assert!(format!("{why:#}").contains("a pipe or a device"), "{why:#}");
        }
    }

    #[test]
    fn names_become_parts_of_addresses() {
        assert_eq!(escaped("a b%.glb"), "a%20b%25.glb");
        assert_eq!(escaped("../ü"), "..%2F%C3%BC");
    }
}
