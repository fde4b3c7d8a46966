//! The program `enfilade-viewer`: opens a scene in a window, draws a screenshot, or serves the viewer as a web page.
#![forbid(unsafe_code)]

#[cfg(not(target_arch = "wasm32"))]
fn main() -> std::process::ExitCode {
    native::main()
}

/// The web build is a library, started by its page.
#[cfg(target_arch = "wasm32")]
fn main() {}

#[cfg(not(target_arch = "wasm32"))]
mod native {
    use anyhow::{Context, Result, anyhow};
    use clap::Parser;
    use eframe::egui::{PointerButton, ViewportBuilder};
    use enfilade_viewer::args::Args;
    use enfilade_viewer::loading::Loading;
    use enfilade_viewer::offscreen::Offscreen;
    use enfilade_viewer::serve::Server;
    use enfilade_viewer::window::{Window, device};
    use std::path::Path;
    use std::process::ExitCode;

    pub(super) fn main() -> ExitCode {
        match run(&Args::parse()) {
            Ok(()) => ExitCode::SUCCESS,
            Err(why) => {
                #[expect(clippy::print_stderr, reason = "the program's own message")]
                {
                    eprintln!("error: {why:#}");
                }
                ExitCode::from(2)
            }
        }
    }

    fn run(args: &Args) -> Result<()> {
        args.check()?;
        match &args.screenshot {
            Some(file) => screenshot(args, file),
            None if args.web => serve(args),
            None => window(args.clone()),
        }
    }

    fn serve(args: &Args) -> Result<()> {
        let server = Server::new(&args.scene, args.port)?;
        #[expect(clippy::print_stdout, reason = "the address is the answer")]
        {
            println!("open {} in a browser; Ctrl+C ends it", server.address);
        }
        server.run()
    }

    fn screenshot(args: &Args, file: &Path) -> Result<()> {
        /// Frames after which the layout of the interface rests.
        const SETTLED: u32 = 4;
        let mut viewer = Offscreen::new(args.size, Loading::file(&args.scene))?;
        args.apply(&mut viewer.app)?;
        (0..SETTLED).for_each(|_| viewer.frame(Vec::new()));
        if let Some(at) = args.click {
            viewer.click(at, PointerButton::Primary);
            (0..SETTLED).for_each(|_| viewer.frame(Vec::new()));
        }
        let picture = viewer.picture()?;
        // Written beside, then renamed, so that a failure leaves what was there.
        let beside = file.with_extension("part.png");
        let fails = || format!("cannot write {}", file.display());
        picture.save(&beside).with_context(fails)?;
        std::fs::File::open(&beside)
            .and_then(|written| written.sync_all())
            .and_then(|()| std::fs::rename(&beside, file))
            .with_context(fails)
    }

    fn window(args: Args) -> Result<()> {
        let [width, height] = args.size.map(|side| side as f32);
        let options = eframe::NativeOptions {
            renderer: eframe::Renderer::Wgpu,
            wgpu_options: device(),
            viewport: ViewportBuilder::default().with_inner_size([width, height]),
            ..eframe::NativeOptions::default()
        };
        let scene = Loading::file(&args.scene);
        let made = eframe::run_native(
            "Enfilade",
            options,
            Box::new(move |context| Ok(Box::new(Window::new(context, scene, Some(args))?))),
        );
        made.map_err(|why| {
            anyhow!(
                "no window can be opened: {why}; without a display, --screenshot draws to a file, and --web serves a page. \
                 Without a graphics driver, `apt-get install mesa-vulkan-drivers libvulkan1` installs one on Debian or Ubuntu"
            )
        })
    }
}
