//! Wavefront OBJ: bytes in, a triangle soup in the file's own units out. Numbers and fans by `tobj`.
//!
//! Only `v` and `f` lines matter to a mill. They are picked out here first, for three reasons: a complaint can name its line;
//! names, colours, texture and normal indices (which may be in any code page, or broken) cannot spoil the shape; and `l`
//! polylines cannot turn into faces. Materials are ignored. Knows nothing of files, units or frames.

use super::stl::shown;
use crate::geom::Point;

/// Triangles read from an OBJ file, in the file's own unit.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjRead {
    /// Corners as they came; all objects and groups merged.
    pub triangles: Vec<[Point; 3]>,
    /// What was tolerated, for the user to read.
    pub warnings: Vec<String>,
}

/// Why bytes are not a usable OBJ. The display says what; `line` (from 1) says where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ObjError {
    /// A face refers to a vertex that is not there.
    #[error("the face uses vertex {index}, but the file has {vertices} vertices (the first is 1)")]
    Index {
        /// As written.
        index: i64,
        /// Vertices in the whole file, or before the line for a negative index.
        vertices: usize,
        /// Line, from 1.
        line: u64,
    },
    /// A face word that is no index.
    #[error(
        "\"{found}\" is not a vertex index: a face is written \"f 1 2 3\" or \"f 1/1/1 2/2/2 3/3/3\""
    )]
    Face {
        /// What stands there.
        found: String,
        /// Line, from 1.
        line: u64,
    },
    /// A face of one or two corners.
    #[error("a face with {corners} corners: at least 3 are needed")]
    Corners {
        /// How many it has.
        corners: usize,
        /// Line, from 1.
        line: u64,
    },
    /// A vertex that is not three finite numbers.
    #[error("\"{found}\" is not a vertex: expected \"v x y z\" with three finite numbers")]
    Vertex {
        /// What stands there.
        found: String,
        /// Line, from 1.
        line: u64,
    },
    /// No `f` line at all.
    #[error("the OBJ file has {vertices} vertices but no faces: export it as a mesh of triangles")]
    NoFaces {
        /// How many vertices it has.
        vertices: usize,
    },
    /// Nothing that belongs to an OBJ file.
    #[error("not an OBJ file: no line starts with \"v\" or \"f\"")]
    NotObj,
    /// UTF-16 text.
    #[error("this OBJ is text in UTF-16: save it as plain ASCII or UTF-8")]
    Utf16,
    /// The OBJ library refused what looked right here.
    #[error("the OBJ file could not be read: {0}")]
    Library(String),
}

impl ObjError {
    /// Line (from 1) of the complaint, where there is one.
    pub fn line(&self) -> Option<u64> {
        match *self {
            ObjError::Index { line, .. }
            | ObjError::Face { line, .. }
            | ObjError::Corners { line, .. }
            | ObjError::Vertex { line, .. } => Some(line),
            _ => None,
        }
    }
}

/// A line's end is LF, CR LF or CR; a backslash before it joins the next line.
fn logical_lines(bytes: &[u8]) -> impl Iterator<Item = (u64, std::borrow::Cow<'_, [u8]>)> {
    let mut at = if bytes.starts_with(&[0xef, 0xbb, 0xbf]) {
        3
    } else {
        0
    };
    let mut line = 0u64;
    let mut physical = move || -> Option<(u64, &[u8])> {
        let rest = bytes.get(at..).filter(|r| !r.is_empty())?;
        let end = rest
            .iter()
            .position(|b| matches!(b, b'\n' | b'\r'))
            .unwrap_or(rest.len());
        at += end + 1;
        if rest.get(end) == Some(&b'\r') && rest.get(end + 1) == Some(&b'\n') {
            at += 1;
        }
        line += 1;
        Some((line, &rest[..end]))
    };
    std::iter::from_fn(move || {
        let (line, first) = physical()?;
        let Some(head) = first.strip_suffix(b"\\") else {
            return Some((line, std::borrow::Cow::Borrowed(first)));
        };
        let mut joined = head.to_vec();
        while let Some((_, next)) = physical() {
            joined.push(b' ');
            match next.strip_suffix(b"\\") {
                Some(more) => joined.extend(more),
                None => {
                    joined.extend(next);
                    break;
                }
            }
        }
        Some((line, std::borrow::Cow::Owned(joined)))
    })
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|w| !w.is_empty())
}

/// Reads all faces of all objects as triangles (polygons as fans about their first corner). Relative (negative) indices
/// count back from the face's line. Cost: linear. Every coordinate is finite.
pub fn read(bytes: &[u8]) -> Result<ObjRead, ObjError> {
    if bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]) {
        return Err(ObjError::Utf16);
    }
    let mut vertices = 0usize;
    let mut faces = 0usize;
    let mut polygons = 0usize;
    // The shape alone, as tobj will read it.
    let mut shape: Vec<u8> = Vec::with_capacity(bytes.len());
    // A positive index may name a vertex that comes later, so the largest one waits for the end.
    let mut largest = (0i64, 0u64);
    for (line, text) in logical_lines(bytes) {
        let mut words = words(&text);
        match words.next() {
            Some(b"v") => {
                let bad = || ObjError::Vertex {
                    found: shown(text.trim_ascii()),
                    line,
                };
                let mut values = [0.0f64; 4];
                let mut count = 0;
                for word in words {
                    // Coordinates must be numbers; a lone fourth is a weight, three more are a colour and left out.
                    if let Some(value) = values.get_mut(count) {
                        *value = std::str::from_utf8(word)
                            .ok()
                            .and_then(|t| t.parse().ok())
                            .filter(|v: &f64| v.is_finite())
                            .ok_or_else(bad)?;
                        if count < 3 {
                            shape.extend(if count == 0 { &b"v "[..] } else { &b" "[..] });
                            shape.extend(word);
                        }
                    }
                    count += 1;
                }
                match count {
                    4 if values[3] != 0.0 => shape.extend(format!(" {}", values[3]).bytes()),
                    0..=2 | 4 => return Err(bad()),
                    _ => {}
                }
                shape.push(b'\n');
                vertices += 1;
            }
            Some(b"f") => {
                shape.push(b'f');
                let mut corners = 0;
                for word in words {
                    let index = word.split(|b| *b == b'/').next().unwrap_or_default();
                    let index: i64 = std::str::from_utf8(index)
                        .ok()
                        .and_then(|t| t.parse().ok())
                        .ok_or_else(|| ObjError::Face {
                            found: shown(word),
                            line,
                        })?;
                    if index == 0 || index < -(vertices as i64) {
                        return Err(ObjError::Index {
                            index,
                            vertices,
                            line,
                        });
                    }
                    if index > largest.0 {
                        largest = (index, line);
                    }
                    let absolute = if index < 0 {
                        index + vertices as i64 + 1
                    } else {
                        index
                    };
                    shape.extend(format!(" {absolute}").bytes());
                    corners += 1;
                }
                if corners < 3 {
                    return Err(ObjError::Corners { corners, line });
                }
                polygons += usize::from(corners > 3);
                faces += 1;
                shape.push(b'\n');
            }
            _ => {}
        }
    }
    if faces == 0 {
        return Err(match vertices {
            0 => ObjError::NotObj,
            vertices => ObjError::NoFaces { vertices },
        });
    }
    if largest.0 > vertices as i64 {
        return Err(ObjError::Index {
            index: largest.0,
            vertices,
            line: largest.1,
        });
    }
    let options = tobj::LoadOptions {
        triangulate: true,
        single_index: false,
        ..Default::default()
    };
    let (models, _) =
        tobj::load_obj_buf(&mut shape.as_slice(), &options, |_| Ok(Default::default()))
            .map_err(|e| ObjError::Library(e.to_string()))?;
    let mut triangles = Vec::new();
    for model in &models {
        let at = |i: u32| {
            let i = 3 * i as usize;
            model
                .mesh
                .positions
                .get(i..i + 3)
                .map(|p| Point::new(p[0], p[1], p[2]))
        };
        for t in model.mesh.indices.chunks_exact(3) {
            let (Some(a), Some(b), Some(c)) = (at(t[0]), at(t[1]), at(t[2])) else {
                return Err(ObjError::Library("an index points nowhere".to_string()));
            };
            triangles.push([a, b, c]);
        }
    }
    let warnings = if polygons > 0 {
        vec![format!(
            "{polygons} faces with more than 3 corners were split into fans of triangles: where such a face is concave or \
             warped, export triangles instead"
        )]
    } else {
        Vec::new()
    };
    Ok(ObjRead {
        triangles,
        warnings,
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0.5\nv 0 1 0\n";

    fn ok(text: &str) -> ObjRead {
        read(text.as_bytes()).unwrap()
    }

    #[test]
    fn faces_of_all_spellings_give_the_same_triangle() {
        let want = [
            Point::new(0.0, 0.0, 0.0),
            Point::new(1.0, 0.0, 0.0),
            Point::new(1.0, 1.0, 0.5),
        ];
        for face in [
            "f 1 2 3",
            "f 1/7/9 2/8/9 3//9",
            "f -4 -3 -2",
            "f 1 \\\n2 3",
            "\tf  1  2\t3 ",
        ] {
            assert_eq!(
                ok(&format!("{CORNERS}{face}\n")).triangles,
                [want],
                "{face}"
            );
        }
        // Colours, weights, names in any code page, materials that do not exist, a vertex used before it is written.
        assert_eq!(
            ok("f 1 2 3\nv 0 0 0 1 0 0\nv 2 0 0 2\nv 1 1 .5 1 1 1\n").triangles,
            [want]
        );
        let mut odd = b"mtllib no.mtl\no Geh\xe4use\nusemtl \nl 1 2 3 4\np 1\ng\n".to_vec();
        odd.extend(format!("{CORNERS}f 1 2 3\no two\nf 1 2 3\n").bytes());
        assert_eq!(read(&odd).unwrap().triangles, [want, want]);
    }

    #[test]
    fn polygons_become_fans_and_say_so() {
        let r = ok(&format!("{CORNERS}f 1 2 3 4\n"));
        assert_eq!(r.triangles.len(), 2);
        assert_eq!(r.triangles[1][0], r.triangles[0][0]);
        assert_eq!(
            r.warnings,
            [
                "1 faces with more than 3 corners were split into fans of triangles: where such a face is concave or warped, \
              export triangles instead"
            ]
        );
    }

    #[test]
    fn complaints_say_where() {
        for (text, line, message) in [
            (
                "f 1 2 9\n",
                5,
                "the face uses vertex 9, but the file has 4 vertices (the first is 1)",
            ),
            (
                "f 1 0 2\n",
                5,
                "the face uses vertex 0, but the file has 4 vertices (the first is 1)",
            ),
            (
                "\nf -5 1 2\n",
                6,
                "the face uses vertex -5, but the file has 4 vertices (the first is 1)",
            ),
            (
                "f 1 2 9223372036854775807\n",
                5,
                "the face uses vertex 9223372036854775807, but the file has 4 vertices (the first is 1)",
            ),
            (
                "f 1 2 x3\n",
                5,
                "\"x3\" is not a vertex index: a face is written \"f 1 2 3\" or \"f 1/1/1 2/2/2 3/3/3\"",
            ),
            ("f 1 2\n", 5, "a face with 2 corners: at least 3 are needed"),
            (
                "v 1 nan 2\nf 1 2 3\n",
                5,
                "\"v 1 nan 2\" is not a vertex: expected \"v x y z\" with three finite numbers",
            ),
            (
                "v 1 1e999 2\nf 1 2 3\n",
                5,
                "\"v 1 1e999 2\" is not a vertex: expected \"v x y z\" with three finite numbers",
            ),
            (
                "v 1 2\nf 1 2 3\n",
                5,
                "\"v 1 2\" is not a vertex: expected \"v x y z\" with three finite numbers",
            ),
            (
                "v 1 2 3 0\nf 1 2 3\n",
                5,
                "\"v 1 2 3 0\" is not a vertex: expected \"v x y z\" with three finite numbers",
            ),
        ] {
            let e = read(format!("{CORNERS}{text}").as_bytes()).unwrap_err();
            assert_eq!((e.line(), e.to_string().as_str()), (Some(line), message));
        }
        assert_eq!(
            read(CORNERS.as_bytes()).unwrap_err().to_string(),
            "the OBJ file has 4 vertices but no faces: export it as a mesh of triangles"
        );
        assert_eq!(
            read(b"hello\n").unwrap_err().to_string(),
            "not an OBJ file: no line starts with \"v\" or \"f\""
        );
    }

    proptest! {
        #[test]
        fn no_text_panics(lines in proptest::collection::vec("(v|f|l|vt|vn|o|mtllib|usemtl)?[ -~\\\\]{0,20}", 0..12)) {
            let _ = read(format!("{CORNERS}{}", lines.join("\n")).as_bytes());
        }

        #[test]
        fn no_index_panics(a in any::<i64>(), b in -6i64..6, c in any::<i32>(), t in any::<i64>()) {
            let _ = read(format!("{CORNERS}vt 0 0\nvn 0 0 1\nf {a}/{t}/{t} {b}/{c}/1 {c}//{t}\n").as_bytes());
        }
    }
}
