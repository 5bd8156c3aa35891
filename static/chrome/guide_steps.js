// The five steps to a first pose, in the order the guide goes through them. A step takes its tool in
// hand and opens its tab; any other way of doing it counts as well.

export const STEPS = [
  {
    name: 'hips',
    tool: 'move',
    word: 'Hips',
    title: 'Drag the waist onto the hips',
    text: 'Put the white diamond where the person’s hips are. The whole body comes along.',
  },
  {
    name: 'height',
    tab: 'body',
    word: 'Height',
    title: 'Match the person’s height',
    text: 'Set Height in the Body tab until head and feet reach as far as the person’s.',
  },
  {
    name: 'limbs',
    tool: 'ends',
    word: 'Limbs',
    title: 'Pull hands and feet into place',
    text: 'Drag the white circles onto the hands and feet. Elbows and knees follow.',
  },
  {
    name: 'depth',
    tool: 'move',
    word: 'Depth',
    title: 'Look from the side',
    text: 'In Side, drag what lies too near or too far. Nothing moves in the camera view.',
  },
  {
    name: 'key',
    word: 'Key',
    title: 'Press K',
    text: 'This frame becomes a keyframe: the motion will pass exactly through this pose.',
  },
];

export const END = {
  title: 'The first keyframe stands',
  text: 'Go some 10 to 20 frames on, pose again, press K. Then T tracks the frames between.',
};
