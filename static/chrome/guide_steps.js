// The five steps to a first pose, in the order the guide goes through them.

export const STEPS = [
  {
    name: 'hips',
    word: 'Hips',
    title: 'Drag the waist onto the hips',
    text: 'Put the white diamond where the person’s hips are. The whole body comes along.',
  },
  {
    name: 'height',
    word: 'Height',
    title: 'Make the body as tall',
    text: 'Set Height in the Body tab until head and feet reach as far as the person’s.',
  },
  {
    name: 'limbs',
    word: 'Limbs',
    title: 'Pull hands and feet into place',
    text: 'Drag the white circles onto the hands and feet. Elbows and knees follow.',
  },
  {
    name: 'depth',
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
