//! From a path to a [`Mesh`] in millimetres: which format it is, who reads it, and the one place where its numbers are checked.
//!
//! Behind this border every coordinate is finite, within a kilometre of the origin, and at least one triangle has area.

use std::path::Path;
use std::str::FromStr;

use serde::Serialize;

use super::check::{Soundness, check};
use super::error::PartError;
use super::mesh::Mesh;
use super::{obj, stl};

/// The unit a part file was drawn in. STL and OBJ do not say, so the user must.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Units {
    /// Millimetres.
    #[default]
    Mm,
    /// Inches of 25.4 mm.
    Inch,
}

impl Units {
    /// Millimetres in one unit.
    pub fn mm(self) -> f64 {
        match self {
            Units::Mm => 1.0,
            Units::Inch => 25.4,
        }
    }
}

impl FromStr for Units {
    type Err = String;

    /// Reads `mm` or `inch` (also `in`).
    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim().to_ascii_lowercase().as_str() {
            "mm" => Ok(Units::Mm),
            "inch" | "in" => Ok(Units::Inch),
            _ => Err(format!("unit \"{text}\" is not known: write mm or inch")),
        }
    }
}

/// What a part file turned out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Format {
    /// Binary STL.
    #[serde(rename = "binary STL")]
    StlBinary,
    /// ASCII STL.
    #[serde(rename = "ASCII STL")]
    StlAscii,
    /// Wavefront OBJ.
    #[serde(rename = "OBJ")]
    Obj,
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Format::StlBinary => "binary STL",
            Format::StlAscii => "ASCII STL",
            Format::Obj => "OBJ",
        })
    }
}

/// A part as its file gives it.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// Triangles in mm, in the file's axes.
    pub mesh: Mesh,
    /// How it was read.
    pub format: Format,
    /// What was tolerated while reading, for the user.
    pub warnings: Vec<String>,
    /// What is wrong with the triangles; nothing in it stops a job.
    pub soundness: Soundness,
}

/// Farthest a coordinate may be from the origin, mm: beyond it a micrometre is lost in rounding, and no mill reaches it.
pub const FARTHEST_MM: f64 = 1.0e6;

/// Loads a part file: the format by its name first, then by its content. Errors name the file and what to do.
pub fn load(path: &Path, units: Units) -> Result<Loaded, PartError> {
    let name = path.display().to_string();
    let read = |source| PartError::Read {
        path: name.clone(),
        source,
    };
    let kind = std::fs::metadata(path).map_err(read)?;
    if kind.is_dir() {
        return Err(PartError::Directory { path: name });
    }
    if !kind.is_file() {
        return Err(PartError::NotAFile { path: name });
    }
    let bytes = std::fs::read(path).map_err(read)?;
    from_bytes(&name, &bytes, units)
}

/// The same for bytes in memory; `name` is what errors call them, and its ending is the first guess at the format.
pub fn from_bytes(name: &str, bytes: &[u8], units: Units) -> Result<Loaded, PartError> {
    let path = name.to_string();
    if bytes.is_empty() {
        return Err(PartError::Empty { path });
    }
    let extension = Path::new(name)
        .extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase())
        .unwrap_or_default();
    let exact = stl::is_exactly_binary(bytes);
    if !exact {
        refuse_others(name, &extension, bytes)?;
    }
    let as_stl = || {
        stl::read(bytes).map(|r| {
            let format = if r.binary {
                Format::StlBinary
            } else {
                Format::StlAscii
            };
            (r.triangles, format, r.warnings)
        })
    };
    let as_obj = || obj::read(bytes).map(|r| (r.triangles, Format::Obj, r.warnings));
    let stl_error = |error| PartError::Stl {
        path: path.clone(),
        error,
    };
    let obj_error = |error| PartError::Obj {
        path: path.clone(),
        error,
    };
    let misnamed = |(triangles, format, mut warnings): (_, Format, Vec<String>)| {
        warnings.insert(
            0,
            format!("the name ends in .{extension} but the content is {format}: read as that"),
        );
        (triangles, format, warnings)
    };
    let (triangles, format, warnings) = match extension.as_str() {
        "stl" => match as_stl() {
            Ok(r) => r,
            Err(e @ stl::StlError::NotStl(_)) => {
                as_obj().map(misnamed).map_err(|_| stl_error(e))?
            }
            Err(e) => return Err(stl_error(e)),
        },
        "obj" if exact => as_stl().map(misnamed).map_err(stl_error)?,
        "obj" => match as_obj() {
            Ok(r) => r,
            Err(e @ obj::ObjError::NotObj) => as_stl().map(misnamed).map_err(|_| obj_error(e))?,
            Err(e) => return Err(obj_error(e)),
        },
        _ => {
            let solid = bytes
                .trim_ascii_start()
                .get(..5)
                .is_some_and(|w| w.eq_ignore_ascii_case(b"solid"));
            if exact || solid {
                as_stl().map_err(stl_error)?
            } else {
                match as_obj() {
                    Ok(r) => r,
                    Err(obj::ObjError::NotObj) => return Err(PartError::Unknown { path }),
                    Err(e) => return Err(obj_error(e)),
                }
            }
        }
    };
    finish(name, triangles, format, warnings, units)
}

fn finish(
    name: &str,
    mut triangles: Vec<[crate::geom::Point; 3]>,
    format: Format,
    warnings: Vec<String>,
    units: Units,
) -> Result<Loaded, PartError> {
    let path = name.to_string();
    if triangles.is_empty() {
        return Err(PartError::NoTriangles { path });
    }
    let scale = units.mm();
    if scale != 1.0 {
        for corner in triangles.iter_mut().flatten() {
            corner.coords *= scale;
        }
    }
    for (i, t) in triangles.iter().enumerate() {
        let bad = t
            .iter()
            .flat_map(|p| p.iter())
            .find(|v| v.abs() > FARTHEST_MM || v.is_nan());
        if let Some(v) = bad {
            let value = if v.is_nan() {
                "not a number (NaN)".to_string()
            } else if v.is_infinite() {
                "infinite".to_string()
            } else {
                format!("{v:e} mm, more than a kilometre out")
            };
            return Err(PartError::Coordinate {
                path,
                triangle: i + 1,
                value,
            });
        }
    }
    let mesh = Mesh { triangles };
    let soundness = check(&mesh);
    if soundness.degenerate_triangles == soundness.triangles {
        return Err(PartError::NoArea {
            path,
            triangles: soundness.triangles,
        });
    }
    Ok(Loaded {
        mesh,
        format,
        warnings,
        soundness,
    })
}

/// Names files that are something else, so that nobody has to guess why a "broken STL" was refused.
fn refuse_others(name: &str, extension: &str, bytes: &[u8]) -> Result<(), PartError> {
    let path = name.to_string();
    let starts = |magic: &[u8]| bytes.starts_with(magic);
    let text = bytes.trim_ascii_start();
    let pictures: [(&[u8], &'static str); 11] = [
        (b"\x89PNG", "a PNG picture"),
        (b"\xff\xd8\xff", "a JPEG picture"),
        (b"GIF8", "a GIF picture"),
        (b"II*\0", "a TIFF picture"),
        (b"MM\0*", "a TIFF picture"),
        (b"%PDF", "a PDF document"),
        (b"\x1f\x8b", "a gzip archive"),
        (b"7z\xbc\xaf", "a 7z archive"),
        (b"Rar!", "a RAR archive"),
        (b"\x7fELF", "a program"),
        (b"%!PS", "a PostScript document"),
    ];
    if let Some((_, what)) = pictures.iter().find(|(magic, _)| starts(magic)) {
        return Err(PartError::NotAPart { path, what });
    }
    let length_of_bmp = bytes
        .get(2..6)
        .map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    if starts(b"BM") && length_of_bmp.is_some_and(|n| n as usize == bytes.len()) {
        return Err(PartError::NotAPart {
            path,
            what: "a BMP picture",
        });
    }
    if starts(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        return Err(PartError::NotAPart {
            path,
            what: "a WebP picture",
        });
    }
    // An IGES file has 80-column lines whose 73rd column is the section, "S" at first.
    let iges = bytes.get(72) == Some(&b'S')
        && bytes
            .get(73..80)
            .is_some_and(|n| n.iter().all(|b| b.is_ascii_digit() || *b == b' '));
    let by_content = if text.starts_with(b"ISO-10303-21") {
        Some("STEP")
    } else if iges {
        Some("IGES")
    } else if starts(b"PK\x03\x04") {
        if extension != "3mf" && !bytes.windows(8).take(65536).any(|w| w == b"3dmodel.") {
            return Err(PartError::NotAPart {
                path,
                what: "a ZIP archive",
            });
        }
        Some("3MF")
    } else if text.starts_with(b"ply\n") || text.starts_with(b"ply\r") {
        Some("PLY")
    } else if starts(b"glTF") {
        Some("glTF")
    } else {
        None
    };
    let by_name = match extension {
        "step" | "stp" | "p21" => Some("STEP"),
        "iges" | "igs" => Some("IGES"),
        "3mf" => Some("3MF"),
        "ply" => Some("PLY"),
        "glb" | "gltf" => Some("glTF"),
        "amf" => Some("AMF"),
        "off" => Some("OFF"),
        "brep" | "brp" => Some("BREP"),
        "dxf" => Some("DXF"),
        "fcstd" => Some("FreeCAD"),
        "blend" => Some("Blender"),
        "sldprt" => Some("SolidWorks"),
        "f3d" => Some("Fusion"),
        "3dm" => Some("Rhino"),
        _ => None,
    };
    match by_content.or(by_name) {
        Some(what) => Err(PartError::NotYet { path, what }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const TRI: &str = "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 2 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";

    fn refusal(name: &str, bytes: &[u8]) -> String {
        from_bytes(name, bytes, Units::Mm).unwrap_err().to_string()
    }

    #[test]
    fn inches_are_25_4_mm() {
        let l = from_bytes("a.stl", TRI.as_bytes(), Units::Inch).unwrap();
        assert_eq!(l.mesh.triangles[0][1].x, 50.8);
        assert!((l.soundness.area_mm2 - 25.4 * 25.4).abs() < 1e-9);
        assert_eq!(l.format, Format::StlAscii);
        assert_eq!("inch".parse(), Ok(Units::Inch));
        assert_eq!(
            "furlong".parse::<Units>().unwrap_err(),
            "unit \"furlong\" is not known: write mm or inch"
        );
    }

    #[test]
    fn other_files_are_called_by_their_name() {
        for (name, bytes, message) in [
            (
                "p.stl",
                &b"\x89PNG\r\n\x1a\n0000"[..],
                "p.stl: this is a PNG picture, not a part: name an STL or OBJ file",
            ),
            (
                "p.stl",
                b"\xff\xd8\xff\xe0",
                "p.stl: this is a JPEG picture, not a part: name an STL or OBJ file",
            ),
            (
                "p.obj",
                b"BM\x08\0\0\0\0\0",
                "p.obj: this is a BMP picture, not a part: name an STL or OBJ file",
            ),
            (
                "p.stl",
                b"PK\x03\x04....",
                "p.stl: this is a ZIP archive, not a part: name an STL or OBJ file",
            ),
            (
                "p.3mf",
                b"PK\x03\x04....",
                "p.3mf: 3MF files are not read yet: export the part as STL or OBJ",
            ),
            (
                "p.STEP",
                b"x",
                "p.STEP: STEP files are not read yet: export the part as STL or OBJ",
            ),
            (
                "p.stl",
                b"ISO-10303-21;\nHEADER;",
                "p.stl: STEP files are not read yet: export the part as STL or OBJ",
            ),
            (
                "p.igs",
                b"x",
                "p.igs: IGES files are not read yet: export the part as STL or OBJ",
            ),
            (
                "p.xyz",
                b"hello there",
                "p.xyz: neither the name nor the content is one of a part file: name an STL or OBJ file",
            ),
            (
                "p.stl",
                b"",
                "p.stl: the file is empty: export the part again",
            ),
            (
                "p.stl",
                b"solid\nendsolid",
                "p.stl: the file holds no triangles: export the part again",
            ),
            (
                "p.stl",
                b"solid\nfacet norm",
                "p.stl:2:7: expected \"normal\", found \"norm\"",
            ),
            (
                "p.obj",
                b"v 0 0 0\nf 1 2 3",
                "p.obj:2:1: the face uses vertex 3, but the file has 1 vertices (the first is 1)",
            ),
        ] {
            assert_eq!(refusal(name, bytes), message);
        }
    }

    #[test]
    fn numbers_that_are_no_place_name_their_triangle() {
        let second = |from: &str, to: &str| {
            let body = TRI
                .trim_start_matches("solid\n")
                .trim_end_matches("endsolid\n");
            format!("solid\n{body}{}endsolid\n", body.replace(from, to))
        };
        for (to, message) in [
            (
                "nan",
                "p.stl: triangle 2 (the first is 1) has a coordinate that is not a number (NaN): repair the part and export it again",
            ),
            (
                "-inf",
                "p.stl: triangle 2 (the first is 1) has a coordinate that is infinite: repair the part and export it again",
            ),
            (
                "2e30",
                "p.stl: triangle 2 (the first is 1) has a coordinate that is 2e30 mm, more than a kilometre out: repair the part and export it again",
            ),
        ] {
            assert_eq!(
                refusal(
                    "p.stl",
                    second("vertex 2", &format!("vertex {to}")).as_bytes()
                ),
                message
            );
        }
        assert_eq!(
            refusal("p.stl", TRI.replace("0 1 0", "1 0 0").as_bytes()),
            "p.stl: none of the 1 triangles has any area: export the part again, with more digits"
        );
    }

    #[test]
    fn a_wrong_ending_is_forgiven_and_told() {
        let l = from_bytes("a.obj", TRI.as_bytes(), Units::Mm).unwrap();
        assert_eq!(
            l.warnings,
            ["the name ends in .obj but the content is ASCII STL: read as that"]
        );
        let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
        let l = from_bytes("a.stl", obj, Units::Mm).unwrap();
        assert_eq!(
            l.warnings,
            ["the name ends in .stl but the content is OBJ: read as that"]
        );
        for name in ["a", "a.part"] {
            assert_eq!(
                from_bytes(name, obj, Units::Mm).unwrap().format,
                Format::Obj
            );
            assert_eq!(
                from_bytes(name, TRI.as_bytes(), Units::Mm).unwrap().format,
                Format::StlAscii
            );
        }
    }

    #[test]
    fn folders_devices_and_nothing() {
        let dir = tempfile::tempdir().unwrap();
        let e = load(dir.path(), Units::Mm).unwrap_err().to_string();
        assert!(
            e.ends_with(": this is a directory: name the STL or OBJ file inside it"),
            "{e}"
        );
        let e = load(&dir.path().join("no.stl"), Units::Mm)
            .unwrap_err()
            .to_string();
        assert!(e.contains("no.stl: cannot be read: "), "{e}");
    }
}
