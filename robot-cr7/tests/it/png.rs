//! `--format png`: images of the size of the pictures, with text that can be read.
#![cfg(all(feature = "cli", feature = "png"))]

use resvg::tiny_skia::Pixmap;
use robot_cr7::SamplePath;
use robot_cr7::plot::PngPainter;

use crate::common::Desk;

const PICTURES: [&str; 8] =
    ["path", "path_speed", "motion", "feed", "feed_time", "joint_velocity", "joint_acceleration", "joint_jerk"];

/// The picture without its texts.
fn without_text(svg: &str) -> String {
    let mut parts = svg.split("<text");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |all, part| all + part.split_once("</text>").expect("a text ends").1)
}

/// Pixels of the line of the title that are darker than any line of a grid.
fn dark_in_title(image: &Pixmap) -> usize {
    let inside = |i: usize| {
        let (x, y) = (i % image.width() as usize, i / image.width() as usize);
        (40..900).contains(&x) && (24..70).contains(&y)
    };
    let dark = |pixel: &resvg::tiny_skia::PremultipliedColorU8| pixel.red().max(pixel.green()).max(pixel.blue()) < 110;
    image.pixels().iter().enumerate().filter(|(i, pixel)| inside(*i) && dark(pixel)).count()
}

fn size(svg: &str, name: &str) -> u32 {
    let value = svg.split(&format!(" {name}=\"")).nth(1).and_then(|rest| rest.split('"').next());
    value.expect("an attribute").parse().expect("a whole number")
}

#[test]
fn pictures_stand_as_png_beside_the_svg() {
    if PngPainter::new().is_err() {
        println!("skipped: this machine has no font");
        return;
    }
    let desk = Desk::new("png");
    desk.write("six.json", SamplePath::SixPoint.json());
    let report = desk.run(&["plan", "six.json", "--format", "png", "--json"]).done().json();
    let painter = PngPainter::new().expect("a machine with fonts");
    for name in PICTURES {
        let file = |ending: &str| desk.folder.join(format!("out/{name}.{ending}"));
        let svg = std::fs::read_to_string(file("svg")).expect("an SVG");
        let bytes = std::fs::read(file("png")).expect("a PNG");
        let image = Pixmap::decode_png(&bytes).expect("an image");
        assert_eq!((image.width(), image.height()), (2 * size(&svg, "width"), 2 * size(&svg, "height")), "{name}");
        assert!(bytes.len() < 1_000_000, "{name}: {} bytes", bytes.len());
        // Lines and grounds of several colours.
        let mut colours: Vec<_> = image.pixels().iter().map(|p| (p.red(), p.green(), p.blue())).collect();
        colours.sort_unstable();
        colours.dedup();
        assert!(colours.len() > 30, "{name}: {} colours", colours.len());
        let mute = painter.paint(&without_text(&svg)).expect("painted");
        let mute = Pixmap::decode_png(&mute).expect("an image");
        let (with, without) = (dark_in_title(&image), dark_in_title(&mute));
        assert!(with > 400 && without == 0, "{name}: {with} and {without}");
        let listed = report["files"].as_array().expect("a list").iter().any(|f| f == &format!("out/{name}.png"));
        assert!(listed, "{name} in {report}");
    }
    // What an earlier run left is not taken for the result of this one.
    desk.run(&["plan", "six.json"]).done();
    assert!(!desk.folder.join("out/path.png").exists() && desk.folder.join("out/path.svg").exists());
}

#[test]
fn a_program_in_parts_has_them_too() {
    if PngPainter::new().is_err() {
        println!("skipped: this machine has no font");
        return;
    }
    let desk = Desk::new("png_program");
    desk.write("dwell.ngc", "G21 G90 F3000\nG1 X20\nG4 P0.1\nG1 Y20\n");
    desk.run(&["plan", "dwell.ngc", "--format", "png"]).done();
    assert!(PICTURES.iter().all(|name| desk.folder.join(format!("out/{name}.png")).exists()));
}

#[test]
fn every_command_that_draws_has_them() {
    if PngPainter::new().is_err() {
        println!("skipped: this machine has no font");
        return;
    }
    let desk = Desk::new("png_commands");
    let zeros = ["0"; 6];
    let [from, to] = [&["--from-deg"][..], &["--to-deg", "20"]].map(|flag| flag.to_vec());
    let joint_move = [&["move"][..], &from, &zeros, &to, &zeros[1..]].concat();
    desk.write("way.toml", robot_cr7::ScheduleFile::WAYPOINTS);
    desk.write("six.json", SamplePath::SixPoint.json());
    for command in [joint_move, vec!["run"], vec!["online"], vec!["schedule", "way.toml"], vec!["inspect", "six.json"]]
    {
        let out = desk.folder.join(command[0]);
        let folder = out.to_string_lossy().into_owned();
        desk.run(&[&command[..], &["--out", &folder, "--format", "png"]].concat()).done();
        let files = std::fs::read_dir(&out).expect("a folder").map(|file| file.expect("a file").path());
        let pictures: Vec<_> = files.filter(|file| file.extension().is_some_and(|e| e == "svg")).collect();
        assert!(!pictures.is_empty(), "{command:?}");
        for picture in &pictures {
            let bytes = std::fs::read(picture.with_extension("png")).expect("a PNG beside it");
            assert!(Pixmap::decode_png(&bytes).is_ok(), "{}", picture.display());
        }
        // Without it none stays.
        desk.run(&[&command[..], &["--out", &folder]].concat()).done();
        assert!(pictures.iter().all(|picture| picture.exists() && !picture.with_extension("png").exists()));
    }
}
