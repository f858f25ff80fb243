//! Small seeds and the words of each format.

/// Two triangles each, as ASCII and as binary STL.
pub fn stl() -> Vec<Vec<u8>> {
    let facet = "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 10.5 0 0\n  vertex 0 1e1 -0.25\n endloop\nendfacet\n";
    let ascii = format!(
        "solid part\n{facet}{}endsolid part\n",
        facet.replace("10.5", "-3")
    );
    let mut binary = vec![b' '; 80];
    binary.extend(4u32.to_le_bytes());
    for i in 0..4u8 {
        let numbers = [
            0.0f32,
            0.0,
            1.0,
            0.0,
            0.0,
            f32::from(i),
            10.0,
            0.0,
            0.0,
            0.0,
            10.0,
            -2.5,
        ];
        binary.extend(numbers.iter().flat_map(|v| v.to_le_bytes()));
        binary.extend([0, 0]);
    }
    let mut like_ascii = binary.clone();
    like_ascii.splice(..5, *b"solid");
    vec![
        ascii.clone().into_bytes(),
        ascii.replace('\n', "\r\n").to_uppercase().into_bytes(),
        binary,
        like_ascii,
    ]
}

/// Words of ASCII STL.
pub const STL_WORDS: [&str; 12] = [
    "solid ",
    "endsolid\n",
    "facet ",
    "normal ",
    "outer loop\n",
    "vertex ",
    "endloop\n",
    "endfacet\n",
    "facet normal 0 0 1\n",
    "vertex 1 2 3\n",
    "COLOR=",
    "\n",
];

/// Faces of all kinds of corners.
pub fn obj() -> Vec<Vec<u8>> {
    [
        "# part\nmtllib a.mtl\no cube\nv 0 0 0\nv 10 0 0 1.0\nv 10 10 0.5\nv 0 10 0 0.1 0.2 0.3\nvt 0 0\nvn 0 0 1\ns off\nusemtl m\n\
         f 1 2 3\nf 1/1/1 3/1/1 4/1/1\nf -4//1 -3//1 -2//1 -1//1\n",
        "g all\r\nv 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nv 0 0 1\r\nf 1/ 2/ 3/\r\nf 1 2 3 4 5 \\\r\n 3\r\nl 1 2\r\np 1\r\n",
        "v 1 2 3\nv 4 5 6\nv 7 8 10\nf 1 2 3\nvp 1 2\ncstype bezier\n",
    ]
    .map(|t| t.as_bytes().to_vec())
    .into()
}

/// Words of OBJ.
pub const OBJ_WORDS: [&str; 16] = [
    "v ",
    "vn ",
    "vt ",
    "f ",
    "f 1 2 3\n",
    "f -1 -2 -3\n",
    "o ",
    "g ",
    "s ",
    "usemtl ",
    "mtllib ",
    "l ",
    "//",
    "/",
    "\\\n",
    "#",
];

/// Short programs of every family of dialects.
pub fn gcode() -> Vec<Vec<u8>> {
    [
        "%\n(plain)\nG21 G90 G17 G94\nT1 M6\nS10000 M3\nG54\nM8\nG0 X0 Y0\nZ5.\nG1 Z-1.25 F300\nX10 Y-2.5\nG2 X20 Y0 I5 J2.5\n\
         G3 X10 R20\nG4 P0.5\nG53 G0 Z0\nM5 M9\nM30\n%\n",
        "N10 G20 G91\nN20 G38.2 Z-1 F2 ; probe\nN30 G92 Z0\nN40 G10 L2 P1 X0 Y0 Z0\nN50 G28.1\nN60 G28 Z1\nN70 G43.1 Z0.5\nG49\n/ G0 X1\nM0\nM2\n",
        "G17 G90 G98\nG81 X0 Y0 Z-5 R2 F100\nX10\nG83 X20 Z-20 R2 Q3 L2\nG73 Z-9 Q1.5 R1\nG82 Z-2 R1 P0.2\nG80\nG93 G1 X1 F2\nG95 F0.1\nG94\nM30\n",
        "%\nO1000 (FANUC)\n#100=[#1+2.5]*SIN[30]\n#101=#100\nWHILE [#101 LT 5] DO1\n#101=#101+1\nG1 X#101 F[100/2]\nEND1\n\
         IF [#100 EQ 1] GOTO 20\nN20 M98 P2000 L2\nG65 P2000 A1. B2.\nM30\nO2000\nG0 X1.\nM99\n%\n",
        "o100 sub\n  G1 X[#1*2] F100\no100 endsub\n#<depth> = -1.5\no101 if [#<depth> LT 0]\n  o100 call [3]\no101 else\n (debug, #<depth>)\n\
         o101 endif\no102 repeat [3]\nG91 G1 X1\no102 endrepeat\nG64 P0.01\nM2\n",
        "; Sinumerik\nDEF REAL DEPTH=-2.5\nR1=10 R2=R1*2\nG90 G17 G71 G54\nT=\"BALL\" D1 M6\nS8000 M3\nG0 X=R1 Y0\nG1 Z=DEPTH F=R2\n\
         G2 X20 Y0 I=AC(15) J=AC(0) TURN=1\nCR=5\nMCALL CYCLE83(5,0,1,-20)\nLOOP:\nIF R1>5 GOTOF ENDE\nREPEAT LOOP P=2\nENDE:\nCYCLE832(0.01,1)\nM30\n",
        "BEGIN PGM PART MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-20\n2 BLK FORM 0.2 X+100 Y+100 Z+0\n3 TOOL CALL 1 Z S8000 F500\n4 L Z+50 R0 FMAX M3\n\
         5 L X+10,5 Y-2 R0 FMAX\n6 L Z-1 F250 M8\n7 CC X+20 Y+0\n8 C X+30 Y+0 DR+\n9 CR X+10 Y+0 R-10 DR-\n10 LP PR+10 PA+30\n11 FN 0: Q1 = +5\n\
         12 Q2 = Q1 * SIN 30\n13 LBL 1\n14 L IX+Q1\n15 CALL LBL 1 REP 3/2\n16 CYCL DEF 32.0 TOLERANZ\n17 CYCL DEF 32.1 T0.01\n18 M30\nEND PGM PART MM\n",
        "N1 G21*18\nN2 M110 N2*97\nM204 P500 T500\nG28 X Y\nG0 X1 Y1 F3000\nG1 Z-1 E0 F300\nM117 hello\nM106 S255\nG4 S1\nM400\nM84\n",
        "VC1=10\nG15 H1\nCALL O100 Q2\nG0 X=VC1\nIF [VC1 GT 5] N100\nN100 G1 Z-5 F100\nNOEX DEF WORK\nRTS\nM2\nG116 T1\nG61.1\nG5.1 Q1\n",
    ]
    .map(|t| t.as_bytes().to_vec())
    .into()
}

/// Words of G-code, of all dialects.
pub const GCODE_WORDS: [&str; 96] = [
    "G0 ",
    "G1 ",
    "G2 ",
    "G3 ",
    "G4 P",
    "G10 L2 P1 ",
    "G10 L20 P0 ",
    "G17 ",
    "G18 ",
    "G19 ",
    "G20 ",
    "G21 ",
    "G28 ",
    "G28.1 ",
    "G30 ",
    "G38.2 ",
    "G40 ",
    "G41 D1 ",
    "G43 H1 ",
    "G43.1 Z",
    "G49 ",
    "G53 ",
    "G54 ",
    "G54.1 P48 ",
    "G59.3 ",
    "G61 ",
    "G64 P",
    "G65 P1 ",
    "G73 ",
    "G80 ",
    "G81 ",
    "G83 ",
    "G90 ",
    "G90.1 ",
    "G91 ",
    "G91.1 ",
    "G92 ",
    "G92.1 ",
    "G93 ",
    "G94 ",
    "G95 ",
    "G98 ",
    "G99 ",
    "M0 ",
    "M1 ",
    "M2 ",
    "M3 ",
    "M5 ",
    "M6 ",
    "M8 ",
    "M9 ",
    "M30 ",
    "M98 P",
    "M99 ",
    "X",
    "Y",
    "Z",
    "I",
    "J",
    "K",
    "R",
    "F",
    "S",
    "T",
    "N",
    "#1=",
    "#[#1]",
    "#<a>",
    "[",
    "]",
    "[1/0]",
    "SQRT[-1]",
    "ATAN[1]/[0]",
    "MOD ",
    "**",
    "WHILE[1]DO1\n",
    "END1\n",
    "GOTO 1\n",
    "IF[1 EQ 1]THEN ",
    "o1 sub\n",
    "o1 endsub\n",
    "o1 call [1]\n",
    "(",
    ")",
    ";",
    "%\n",
    "/",
    "*71",
    "R1=",
    "=AC(",
    "LBL 1\n",
    "CALL LBL 1 REP 65535\n",
    "CC ",
    "DR+ ",
    "Q1=",
    "REPEAT ",
];

/// The machines and dialects that come with the program.
pub fn toml() -> Vec<Vec<u8>> {
    let files = morsemill::machine::BUILT_IN
        .iter()
        .chain(morsemill::post::BUILT_IN.iter());
    files.map(|(_, text)| text.as_bytes().to_vec()).collect()
}

/// Words of TOML and of our files.
pub const TOML_WORDS: [&str; 28] = [
    "title = ",
    "controller = ",
    "post = \"grbl\"\n",
    "travel_mm = ",
    "[300, 300, 100]",
    "baud = ",
    "[lines]\n",
    "[[lines]]\n",
    "[a.b]\n",
    "= ",
    "\"",
    "\"\"\"",
    "'''",
    "'",
    "[",
    "]",
    "{",
    "}",
    "{a = 1}",
    "\\u0000",
    "\\x",
    "1979-05-27T07:32:00Z",
    "0x7fffffffffffffff",
    "0b1",
    "true",
    "{x}",
    "{speed}",
    "#",
];

/// CL files as CAD systems write them.
pub fn cl() -> Vec<Vec<u8>> {
    [
        "$$* Pro/CLfile\n$$-> MFGNO / OP010\nPARTNO / PART\nUNITS / MM\nMULTAX / OFF\nLOADTL / 1\nSPINDL / RPM, 8000.0, CLW\nCOOLNT / ON\n\
         RAPID\nGOTO / 0.0, 0.0, 10.0\nFEDRAT / 500.0, MMPM\nGOTO / 0.0, 0.0, -1.0\nCIRCLE / 10.0, 0.0, -1.0, $\n0.0, 0.0, 1.0, 10.0\n\
         GOTO / 10.0, -10.0, -1.0\nGOTO / 20.0, 0.0, -1.0\nCOOLNT / OFF\nSPINDL / OFF\nFINI\n",
        "TOOL PATH/MILL,TOOL,BALL6\nTLDATA/MILL,6.0000,3.0000,50.0000,0.0000,0.0000\nMSYS/0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0\nPAINT/PATH\n\
         LOADTL/1\nSPINDL/RPM,1000,CLW\nRAPID\nGOTO/1.0,2.0,3.0,0.0,0.0,1.0\nFEDRAT/MMPM,250.0\nGODLTA/0,0,-1\n\
         CIRCLE/0.0,2.0,2.0,0.0,0.0,-1.0,1.0,0.06,0.5,6.0,0.0,TIMES,1\nGOTO/0.0,1.0,2.0\nDELAY/1.5\nSTOP\nOPSTOP\nEND-OF-PATH\nEND\n",
        "$$ CATIA\nPPRINT text, with commas\nCUTTER/6,3,0,3,0,0,50\nINDIRV/1,0,0\nTLON,GOFWD/(CIRCLE/0,0,0,5),ON,(LINE/0,0,0,5,5,0)\n\
         MOVARC/0,0,0,0,0,1,5,ANGLE,90\nGOTO/0,5,0\nFROM/0,0,50\nCLEARP/XYPLAN,20\nRETRCT\nFINI\n",
    ]
    .map(|t| t.as_bytes().to_vec())
    .into()
}

/// Words of CL files.
pub const CL_WORDS: [&str; 32] = [
    "GOTO/",
    "GODLTA/",
    "RAPID\n",
    "FEDRAT/",
    "MMPM",
    "MMPR",
    "IPM",
    "SPINDL/",
    "RPM,",
    "CLW",
    "CCLW",
    "COOLNT/",
    "FLOOD",
    "LOADTL/",
    "TLDATA/",
    "CUTTER/",
    "CIRCLE/",
    "MOVARC/",
    "TIMES,",
    "UNITS/INCHES\n",
    "MULTAX/ON\n",
    "PPRINT ",
    "CYCLE/",
    "END\n",
    "FINI\n",
    "$\n",
    "$$",
    "FROM/",
    "CLEARP/",
    "STOP\n",
    ",",
    "/",
];
