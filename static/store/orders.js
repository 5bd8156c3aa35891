// What may be ordered and in which formats, written by app/export/for_page.py: change it there.

/**
 * An option of an order: its name there, and what a form has to know to ask for it.
 * @typedef {object} Option
 * @property {string} name
 * @property {string} label
 * @property {string} kind
 * @property {string} [empty]  What its field shows while nothing is chosen.
 * @property {string} [note]
 * @property {string} [usual]
 * @property {string[]} [only]  The formats that it matters to; without it all.
 * @property {boolean} [persons]  All but the first choice need a person's body.
 * @property {number} [least]
 * @property {number | null} [most]
 * @property {string} [unit]
 * @property {{ id: string, label: string, note?: string }[]} [options]
 * @property {string[]} [labels]  Of off and on.
 */

/**
 * A file format of motion.
 * @typedef {object} Format
 * @property {string} label
 * @property {string} icon
 * @property {string} reader  Who reads it.
 * @property {string} also  What it is found by.
 * @property {string} alone
 * @property {string} remark
 * @property {string} then  What a person still does with its files, a sentence.
 * @property {string} needs  A package that has to be installed.
 * @property {boolean} gaps
 * @property {boolean} ownTimes
 */

/** @type {Record<string, Option[]>} */
export const EXPORTS = {
  film: [
    {"name": "view", "label": "View", "kind": "view", "options": [{"id": "main", "label": "Camera"}, {"id": "top", "label": "Top"}, {"id": "side", "label": "Side"}, {"id": "front", "label": "Front"}, {"id": "all", "label": "All four views"}, {"id": "orbit", "label": "Once round the body"}], "usual": "main"},
    {"name": "frames", "label": "Frames", "kind": "range"},
    {"name": "size", "label": "Size", "kind": "size", "empty": "As the video"},
    {"name": "fps", "label": "Rate", "kind": "number", "least": 0.1, "most": 1000, "unit": "frames/s", "empty": "As the video"},
    {"name": "style", "label": "Body", "kind": "choice", "options": [{"id": "wire", "label": "Wire"}, {"id": "solid", "label": "Solid"}, {"id": "both", "label": "Both"}], "usual": "both"},
  ],
  pictures: [
    {"name": "frames", "label": "Frames", "kind": "which", "usual": "keyframes"},
    {"name": "style", "label": "Body", "kind": "choice", "options": [{"id": "wire", "label": "Wire"}, {"id": "solid", "label": "Solid"}, {"id": "both", "label": "Both"}], "usual": "both"},
    {"name": "view", "label": "View", "kind": "view", "options": [{"id": "main", "label": "Camera"}, {"id": "top", "label": "Top"}, {"id": "side", "label": "Side"}, {"id": "front", "label": "Front"}, {"id": "all", "label": "All four views"}], "usual": "main"},
    {"name": "size", "label": "Size", "kind": "size", "empty": "As the video"},
    {"name": "background", "label": "Background", "kind": "choice", "options": [{"id": "video", "label": "Video"}, {"id": "none", "label": "Transparent"}], "usual": "video"},
  ],
  sheet: [
    {"name": "columns", "label": "Columns", "kind": "whole", "least": 1, "most": 100, "empty": "As it fits"},
    {"name": "style", "label": "Body", "kind": "choice", "options": [{"id": "wire", "label": "Wire"}, {"id": "solid", "label": "Solid"}, {"id": "both", "label": "Both"}], "usual": "both"},
  ],
  matte: [
    {"name": "kind", "label": "Format", "kind": "choice", "options": [{"id": "png", "label": "PNG, ZIP"}, {"id": "webm", "label": "WebM"}, {"id": "mov", "label": "MOV"}], "usual": "png"},
    {"name": "frames", "label": "Frames", "kind": "range"},
    {"name": "alpha_only", "label": "Picture", "kind": "switch", "labels": ["With alpha", "Alpha alone, grey"]},
  ],
  motion: [
    {"name": "rig", "label": "Rig", "kind": "choice", "options": [{"id": "keypose", "label": "Own names"}, {"id": "mixamo", "label": "Mixamo", "note": "three.js drops the colons of its names"}, {"id": "ue5", "label": "Unreal Engine 5"}, {"id": "metahuman", "label": "MetaHuman"}, {"id": "vrm", "label": "VRM humanoid"}, {"id": "cmu", "label": "CMU motion capture"}, {"id": "smpl", "label": "SMPL"}], "only": ["bvh", "glb", "fbx", "usd"], "persons": true, "usual": "keypose"},
    {"name": "unit", "label": "Unit", "kind": "choice", "options": [{"id": "m", "label": "Metres", "note": "Blender"}, {"id": "cm", "label": "Centimetres", "note": "MotionBuilder, Maya, Daz"}, {"id": "in", "label": "Inches"}], "only": ["bvh"], "usual": "m"},
    {"name": "markers", "label": "Markers", "kind": "choice", "options": [{"id": "keypose", "label": "The body’s joints"}, {"id": "halpe26", "label": "HALPE 26, Pose2Sim"}], "only": ["trc", "c3d"], "persons": true, "usual": "keypose"},
    {"name": "origin", "label": "Origin", "kind": "choice", "options": [{"id": "body", "label": "Below the body, x ahead"}, {"id": "camera", "label": "Below the camera", "note": "the same for every session of a film"}], "usual": "body"},
    {"name": "frames", "label": "Frames", "kind": "range"},
    {"name": "fps", "label": "Rate", "kind": "number", "least": 0.1, "most": 1000, "unit": "frames/s", "empty": "As the video"},
    {"name": "from_zero", "label": "Times", "kind": "switch", "labels": ["As in the video", "From 0"], "note": "From 0 for game engines and web players"},
    {"name": "together", "label": "All bodies in one file", "kind": "switch", "labels": ["Off", "On"], "only": ["trc", "c3d", "csv", "npz"]},
    {"name": "filter_hz", "label": "Low-pass filter", "kind": "number", "least": 0.01, "most": 1000, "unit": "Hz", "empty": "None", "note": "3 dB down there, both passes together"},
  ],
};

/** @type {Record<string, Option[]>} */
export const IMPORTS = {
  motion: [
    {"name": "fps", "label": "Rate", "kind": "number", "least": 0.001, "most": 100000, "unit": "frames/s", "empty": "As the video"},
    {"name": "unit", "label": "Unit", "kind": "choice", "options": [{"id": "m", "label": "Metres"}, {"id": "cm", "label": "Centimetres"}, {"id": "mm", "label": "Millimetres"}, {"id": "auto", "label": "Scale to the body"}], "empty": "Scale to the body"},
    {"name": "world", "label": "World", "kind": "choice", "options": [{"id": "camera", "label": "As the camera sees"}, {"id": "y-up", "label": "Y up"}, {"id": "z-up", "label": "Z up"}], "empty": "Not said by the file"},
    {"name": "individual", "label": "Individual", "kind": "text", "empty": "Choose…"},
    {"name": "offset_frames", "label": "Start frame", "kind": "whole", "least": -1000000, "most": 1000000, "empty": "0", "note": "of the video, at the file’s frame 0; −1 for pictures counted from 1"},
    {"name": "places", "label": "Other names", "kind": "places", "note": "optional"},
  ],
  keypoints: [
    {"name": "layout", "label": "Layout", "kind": "choice", "options": [{"id": "COCO_17", "label": "COCO_17"}, {"id": "COCO_WHOLEBODY_133", "label": "COCO_WHOLEBODY_133"}, {"id": "OPENPOSE_18", "label": "OPENPOSE_18"}, {"id": "BODY_25", "label": "BODY_25"}, {"id": "BODY_25B", "label": "BODY_25B"}, {"id": "HALPE_26", "label": "HALPE_26"}, {"id": "MEDIAPIPE_33", "label": "MEDIAPIPE_33"}], "empty": "Choose…"},
    {"name": "every", "label": "Drafts every", "kind": "whole", "least": 1, "most": 1000000, "empty": "24", "note": "frames"},
    {"name": "frames", "label": "or at frames", "kind": "frames", "empty": "0, 24, 48"},
    {"name": "exchange", "label": "Sides", "kind": "switch", "labels": ["As the file says", "Swap left and right"]},
    {"name": "individual", "label": "Individual", "kind": "text", "empty": "Choose…"},
    {"name": "offset_frames", "label": "Start frame", "kind": "whole", "least": -1000000, "most": 1000000, "empty": "0", "note": "of the video, at the file’s frame 0; −1 for pictures counted from 1"},
    {"name": "places", "label": "Other names", "kind": "places", "note": "optional"},
  ],
  camera: [
    {"name": "offset_frames", "label": "Start frame", "kind": "whole", "least": -1000000, "most": 1000000, "empty": "As numbered", "note": "of the video, at the file’s frame 0; −1 for pictures counted from 1"},
    {"name": "unit", "label": "Unit", "kind": "choice", "options": [{"id": "m", "label": "Metres"}, {"id": "cm", "label": "Centimetres"}, {"id": "mm", "label": "Millimetres"}], "empty": "Metres"},
    {"name": "world", "label": "World", "kind": "choice", "options": [{"id": "y-up", "label": "Y up"}, {"id": "z-up", "label": "Z up"}], "empty": "Y up"},
    {"name": "rotation_order", "label": "Rotation order", "kind": "choice", "options": [{"id": "zxy", "label": "ZXY"}, {"id": "zyx", "label": "ZYX"}, {"id": "xyz", "label": "XYZ"}, {"id": "xzy", "label": "XZY"}, {"id": "yxz", "label": "YXZ"}, {"id": "yzx", "label": "YZX"}], "empty": "ZXY"},
    {"name": "lens_column", "label": "Last column", "kind": "choice", "options": [{"id": "vertical", "label": "Vertical field of view"}, {"id": "horizontal", "label": "Horizontal field of view"}, {"id": "mm", "label": "Focal length, mm"}, {"id": "session", "label": "Nothing: keep the lens"}], "empty": "Vertical field of view"},
  ],
};

/** @typedef {'bvh' | 'glb' | 'fbx' | 'usd' | 'trc' | 'mot' | 'c3d' | 'csv' | 'npz' | 'amass' | 'camera' | 'chan'} FormatName */

/** @type {Record<FormatName, Format>} */
export const FORMATS = {
  bvh: {"label": "BVH", "icon": "bone", "reader": "Blender, MotionBuilder, Daz", "also": "export motion blender maya motionbuilder unreal unity animation mocap", "alone": "Export BVH", "remark": "The file cannot say where in the video it begins", "then": "", "needs": "", "gaps": false, "ownTimes": false},
  glb: {"label": "GLB", "icon": "both", "reader": "Blender, Unreal, Unity, web", "also": "export motion blender gltf unreal unity three web 3d animation rig armature skeleton mixamo metahuman vrm", "alone": "Export GLB", "remark": "", "then": "", "needs": "", "gaps": false, "ownTimes": false},
  fbx: {"label": "FBX", "icon": "both", "reader": "through Blender", "also": "export motion fbx blender maya motionbuilder unreal unity 3ds max rig retarget", "alone": "Export FBX through Blender", "remark": "", "then": "For motion.fbx run: blender --background --python motion_to_fbx.py", "needs": "", "gaps": false, "ownTimes": false},
  usd: {"label": "USD", "icon": "both", "reader": "Omniverse, Houdini, Maya", "also": "export motion usdz usdc openusd universal scene description omniverse houdini maya unreal animation", "alone": "Export USD", "remark": "In Blender, set the frame rate to the video’s", "then": "", "needs": "usd-core", "gaps": false, "ownTimes": false},
  trc: {"label": "TRC", "icon": "trail", "reader": "OpenSim", "also": "export motion opensim markers biomechanics", "alone": "Export TRC", "remark": "", "then": "", "needs": "", "gaps": true, "ownTimes": false},
  mot: {"label": "MOT", "icon": "rot", "reader": "OpenSim joint angles", "also": "export motion", "alone": "Export joint angles as MOT", "remark": "", "then": "", "needs": "", "gaps": false, "ownTimes": false},
  c3d: {"label": "C3D", "icon": "ghost", "reader": "motion laboratories", "also": "export motion vicon qualisys biomechanics lab markers", "alone": "Export C3D", "remark": "", "then": "", "needs": "ezc3d", "gaps": true, "ownTimes": false},
  csv: {"label": "CSV", "icon": "copy", "reader": "joints, angles, verdicts", "also": "export motion table excel spreadsheet angles positions data", "alone": "Export CSV tables", "remark": "", "then": "", "needs": "", "gaps": true, "ownTimes": true},
  npz: {"label": "NPZ", "icon": "quad", "reader": "NumPy", "also": "export motion numpy python arrays data", "alone": "Export NPZ", "remark": "", "then": "", "needs": "", "gaps": true, "ownTimes": true},
  amass: {"label": "AMASS", "icon": "ghost", "reader": "SMPL, motion research", "also": "export motion smpl smplh smplx research npz poses", "alone": "Export AMASS, SMPL poses", "remark": "", "then": "", "needs": "", "gaps": false, "ownTimes": false},
  camera: {"label": "Camera", "icon": "camcorder", "reader": "rotomation, JSON", "also": "export motion rotomation matchmove json lens", "alone": "Export the camera as JSON", "remark": "", "then": "", "needs": "", "gaps": true, "ownTimes": true},
  chan: {"label": "CHAN", "icon": "camcorder", "reader": "the camera for Nuke", "also": "export motion camera nuke rotomation matchmove compositing", "alone": "Export the camera for Nuke", "remark": "", "then": "", "needs": "", "gaps": true, "ownTimes": true},
};

/** Endings of what can be imported. @type {string[]} */
export const ENDINGS = [".bvh", ".trc", ".c3d", ".csv", ".npz", ".pt", ".pth", ".h5", ".hdf5", ".slp", ".json", ".chan", ".glb", ".gltf"];
