//! What can be wrong with expressions and variables.

/// What is wrong with an expression or a variable.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExpressionComplaint {
    /// Something that is no value.
    #[error(
        "found {found:?} where a value should stand (a number, # and a variable, [ ], or a function): correct the expression"
    )]
    NoValue {
        /// What stands there.
        found: char,
    },
    /// The line ends where a value should stand.
    #[error("the line ends where a value should stand: complete the expression")]
    Ends,
    /// Something that is no operator.
    #[error("found {found:?} where an operator or ] should stand: correct the expression")]
    NoOperator {
        /// What stands there.
        found: char,
    },
    /// A bracket is not closed.
    #[error("the bracket is not closed: put ] behind the expression")]
    Open,
    /// A function without its bracket.
    #[error("{function} needs its value in brackets: write {function}[ ... ]")]
    FunctionBracket {
        /// Its name.
        function: Box<str>,
    },
    /// A function that is none.
    #[error(
        "{function} is no function of this controller: use ABS ACOS ASIN ATAN COS EXP FIX FUP LN ROUND SIN SQRT TAN"
    )]
    NoFunction {
        /// What stands there.
        function: Box<str>,
    },
    /// ATAN with one value where two are needed.
    #[error("ATAN takes two values: write ATAN[ ... ]/[ ... ]")]
    AtanTwo,
    /// EXISTS of something that has no name.
    #[error("EXISTS takes the name of a variable: write EXISTS[#<name>]")]
    ExistsName,
    /// Brackets in brackets.
    #[error(
        "brackets inside brackets, more than {limit} deep: compute a part of it on a line before"
    )]
    TooDeep {
        /// The limit.
        limit: u32,
    },
    /// Division by zero.
    #[error("division by zero: a variable has a value that the program was not made for")]
    DivisionByZero,
    /// A function outside what it is defined for.
    #[error(
        "{function} of {value} does not exist: a variable has a value that the program was not made for"
    )]
    Domain {
        /// Its name.
        function: &'static str,
        /// Of what.
        value: f64,
    },
    /// The angle that comes out depends on a setting of the control.
    #[error(
        "{function} gives {angle:.4} or {other:.4} degrees here, by a setting of the control: write the program so that it does not matter"
    )]
    AngleRange {
        /// Its name.
        function: &'static str,
        /// One of the two, degrees.
        angle: f64,
        /// The other.
        other: f64,
    },
    /// Too large, or no number.
    #[error("the result is no number that can be used (too large): check the values")]
    NotFinite,
    /// AND, OR, XOR of something that has no bits.
    #[error(
        "AND, OR and XOR work on the bits of whole numbers from 0, here on {value}: compare first"
    )]
    Bits {
        /// The value.
        value: f64,
    },
    /// A variable that was never set.
    #[error("{name} has no value here: set it on a line before")]
    Unset {
        /// The variable.
        name: Box<str>,
    },
    /// A variable whose value only the machine knows.
    #[error(
        "{name} is known to the machine only (kept from earlier runs, or its own state): set it in the program"
    )]
    Unknown {
        /// The variable.
        name: Box<str>,
    },
    /// A variable that does not exist.
    #[error("{name} is no variable of this controller: use another number")]
    NoSuch {
        /// The variable.
        name: Box<str>,
    },
    /// A variable that a program cannot set, or whose setting would do more than this reader knows.
    #[error(
        "{name} cannot be set here (it belongs to the machine): use a variable of the program's own"
    )]
    ReadOnly {
        /// The variable.
        name: Box<str>,
    },
    /// More names than anyone writes.
    #[error("more than {limit} named variables: use fewer")]
    TooManyNames {
        /// The limit.
        limit: usize,
    },
    /// A variable's number that is none.
    #[error("the number of a variable must be whole and not negative, here it is {value}")]
    NotWhole {
        /// What it is.
        value: f64,
    },
    /// A name that is not closed.
    #[error("the variable's name is not closed: put > behind it")]
    NameOpen,
    /// A setting without its equals sign.
    #[error("{name} stands where a word should begin: to set it write {name}= and a value")]
    NoEquals {
        /// The variable.
        name: Box<str>,
    },
}
