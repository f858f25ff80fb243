//! What is wrong with a part file, in words that name the file, the place and the next step.

use super::obj;
use super::stl;

/// Why a file is no part. Every text names the file and says what to do next.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// The system refused.
    #[error("{path}: cannot be read: {source}")]
    Read {
        /// The file.
        path: String,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A folder.
    #[error("{path}: this is a directory: name the STL or OBJ file inside it")]
    Directory {
        /// The folder.
        path: String,
    },
    /// A device, pipe or socket.
    #[error("{path}: this is not a regular file: name an STL or OBJ file")]
    NotAFile {
        /// The path.
        path: String,
    },
    /// No bytes at all.
    #[error("{path}: the file is empty: export the part again")]
    Empty {
        /// The file.
        path: String,
    },
    /// Something else altogether.
    #[error("{path}: this is {what}, not a part: name an STL or OBJ file")]
    NotAPart {
        /// The file.
        path: String,
        /// What it is, with its article.
        what: &'static str,
    },
    /// A shape, in a format that has no reader here.
    #[error("{path}: {what} files are not read yet: export the part as STL or OBJ")]
    NotYet {
        /// The file.
        path: String,
        /// The format's name.
        what: &'static str,
    },
    /// Neither its name nor its content is known.
    #[error(
        "{path}: neither the name nor the content is one of a part file: name an STL or OBJ file"
    )]
    Unknown {
        /// The file.
        path: String,
    },
    /// The STL reader's complaint.
    #[error("{path}{}: {error}", place(.error.place()))]
    Stl {
        /// The file.
        path: String,
        /// What is wrong.
        error: stl::StlError,
    },
    /// The OBJ reader's complaint.
    #[error("{path}{}: {error}", place(.error.line().map(|l| (l, 1))))]
    Obj {
        /// The file.
        path: String,
        /// What is wrong.
        error: obj::ObjError,
    },
    /// A coordinate that is no place on Earth.
    #[error(
        "{path}: triangle {triangle} (the first is 1) has a coordinate that is {value}: repair the part and export it again"
    )]
    Coordinate {
        /// The file.
        path: String,
        /// Number of the triangle in the file, from 1.
        triangle: usize,
        /// What the coordinate is.
        value: String,
    },
    /// No triangles.
    #[error("{path}: the file holds no triangles: export the part again")]
    NoTriangles {
        /// The file.
        path: String,
    },
    /// Only slivers.
    #[error(
        "{path}: none of the {triangles} triangles has any area: export the part again, with more digits"
    )]
    NoArea {
        /// The file.
        path: String,
        /// How many there are.
        triangles: usize,
    },
}

fn place(at: Option<(u64, u64)>) -> String {
    at.map_or_else(String::new, |(line, column)| format!(":{line}:{column}"))
}
