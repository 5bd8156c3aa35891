// The shapes of what the page knows, for whoever reads it and for the type check: no code.
// The server's sections are made in app/store/sections; angles are degrees, points metres in the camera frame.

/** @typedef {'x' | 'y' | 'z'} Axis */
/** @typedef {'main' | 'top' | 'side' | 'front' | 'free' | 'film'} ViewName */
/** @typedef {[number, number]} Spot */
/** @typedef {[number, number, number]} Point */
/** @typedef {(number | null)[]} Series  One value a frame, null where nothing is known; sent as `Runs`. */

/**
 * @typedef {object} File  What is open.
 * @property {string} name
 * @property {string} video
 * @property {string} path
 * @property {string} id  Of the session's place, as the library calls it.
 * @property {number} frames
 * @property {number} fps
 * @property {number} width
 * @property {number} height
 * @property {number} duration_s
 * @property {number[]} missing
 * @property {number[] | null} times  Only where the rate varies.
 * @property {{ focal_mm: number, device: string } | null} lens  As the file gives it.
 * @property {Taken | null} taken
 * @property {number} repeated  Frames that are copies of the one before.
 */

/**
 * @typedef {object} Taken  How a film was taken.
 * @property {number | null} file_fps  Null for images, which keep no rate.
 * @property {number | null} recorded_fps  As a person says; null where the file's times count.
 * @property {boolean} interlaced
 * @property {boolean} deinterlace
 * @property {number | null} depth  Bits that are used of sixteen.
 * @property {string} numbering  Which images are missing or doubled, a sentence.
 */

/**
 * @typedef {object} Camera
 * @property {number} width
 * @property {number} height
 * @property {number} fx
 * @property {number} fy
 * @property {number} cx
 * @property {number} cy
 * @property {number[]} distortion
 * @property {string} origin
 * @property {string} projection
 * @property {number | null} telephoto_distance_m
 * @property {number} fov_deg
 * @property {number} focal_mm  Of the lens that shows as much on 35 mm film.
 * @property {'guess' | 'file' | 'person' | 'calibration' | 'fitted' | 'turns' | null} lens_source  Null until asked.
 * @property {boolean} lens_is_guess
 * @property {number | null} depth_share  By what share distances may be off; null where the lens is known.
 * @property {Point} up
 * @property {'camera' | 'drawn' | 'feet' | 'found'} up_origin
 * @property {number | null} up_off_deg  What is said as ±; null where nobody knows it, or somebody drew it.
 * @property {boolean} up_is_sure  Whether it is known to 2°, or somebody drew it.
 * @property {number} tilt_deg
 * @property {number} roll_deg
 * @property {{ drafts: number, keyframes: number, segments: number } | null} lifts  What drafting anew for this up
 *   direction would change; null where drafts are as it has them.
 * @property {[Spot, Spot] | null} horizon  Two points of the horizon, pixels; null where it is far from the picture.
 * @property {string} image_version
 */

/**
 * @typedef {object} FilmLens  Of a film's rectified pictures.
 * @property {number} width
 * @property {number} height
 * @property {number} fx
 * @property {number} fy
 * @property {number} cx
 * @property {number} cy
 * @property {string} projection
 * @property {number | null} telephoto_distance_m
 */

/**
 * @typedef {object} FilmsSeen  How the films see the selected part, or the body, in runs of first and last frame.
 * @property {Record<string, [number, number][]>} seen  By the film's id, the first film among them.
 * @property {[number, number][]} disagree  Where no motion is right in two of them.
 * @property {Record<string, string>} places  By the id of a place to review the film in which it is looked at.
 */

/**
 * @typedef {object} Film  Another film of the same motion.
 * @property {string} id
 * @property {string} name
 * @property {number} frames
 * @property {number | null} frame  Its own at the present frame; null beyond its ends.
 * @property {number} begins  The frame of the first film, with its fraction, at which it begins.
 * @property {number} rate  Frames of it per frame of the first film.
 * @property {number | null} sigma  Of `begins`, frames; null where somebody set it.
 * @property {number[]} also  Where it may begin as well.
 * @property {string} words
 * @property {FilmLens} camera
 * @property {number[]} T  From the first camera's frame, as it is at the present frame, to its own: three rows of four.
 * @property {string} image_version
 */

/** @typedef {{ id: string, label: string, title: string, low: string, high: string, off: string }} Tint */

/**
 * @typedef {object} Surface  Observed surfaces; null for a video.
 * @property {string} units
 * @property {string} up
 * @property {number} fps
 * @property {string} weights
 * @property {string} distance
 * @property {string} binding
 * @property {string | null} cameras
 * @property {number | null} model_frame
 * @property {string} problem
 * @property {string} unusable
 * @property {number | null} faces
 * @property {Point | null} middle
 * @property {number | null} rims  Open edges.
 * @property {Tint[]} tints
 * @property {string[]} ramp  Colours from low to high.
 */

/** @typedef {{ key: string, label: string, cm: number, min: number, max: number, at_cm: Point, role: string }} Size */

/**
 * @typedef {object} Part
 * @property {string} name
 * @property {string} label
 * @property {string} short  The label without its side.
 * @property {string | null} parent
 * @property {'L' | 'R' | 'C'} side
 * @property {string | null} mirror
 * @property {string[]} tracked
 * @property {Record<Axis, string>} words
 * @property {Record<Axis, [number, number] | null>} limits
 * @property {Point} joint_cm
 * @property {string[]} landmarks
 * @property {string} shape
 * @property {Size[]} sizes
 * @property {Point[]} corners_cm  Of a box, in its frame, x slowest and z fastest; none of others.
 */

/**
 * @typedef {object} Handle  What can be grabbed.
 * @property {string} name
 * @property {string} kind
 * @property {string} part
 * @property {string} anchor
 * @property {string} label
 * @property {string[]} limb
 */

/**
 * @typedef {object} Body
 * @property {string} name
 * @property {string | null} preset
 * @property {boolean} edited
 * @property {boolean | null} clavicles  Whether shoulders move on the chest; null: a body without.
 * @property {number} height_cm
 * @property {boolean} is_persons  Whether keypoints of a person can be compared with it.
 * @property {boolean} is_animals  Whether those of an animal can.
 * @property {number} dof_count
 * @property {number} dof_total
 * @property {{ name: string, label: string, kind: 'adult' | 'child' | 'animal' | 'object' }[]} presets
 * @property {{ kind: string, label: string }[]} shapes
 * @property {{ label: string, parts: string[] }[]} lanes
 * @property {Part[]} parts
 * @property {Handle[]} handles
 */

/**
 * @typedef {object} Looks  Where one looks, and the switches.
 * @property {number} frame
 * @property {string | null} selected
 * @property {string} body  The id of the body that is posed.
 * @property {'wire' | 'solid' | 'both'} mode
 * @property {number} opacity
 * @property {boolean} ghosts
 * @property {boolean} trail
 * @property {boolean} floor  Whether the camera view shows it.
 * @property {boolean} background  Whether the camera view shows the points that tell how the camera moves.
 * @property {boolean} live
 * @property {boolean} limits
 * @property {'part' | 'parent' | 'view'} axes
 * @property {boolean} link
 * @property {string} tint
 */

/**
 * @typedef {object} Gesture  What is shown beside the pointer.
 * @property {string} label
 * @property {string} value
 * @property {string} change
 * @property {string | null} part
 * @property {Axis | null} axis
 * @property {number | null} angle_rad
 * @property {{ centre: Point, radius_m: number } | null} reach
 * @property {boolean} out_of_reach
 * @property {number | null} depth_m
 * @property {string[]} unreached  Names of handles that were to stay and cannot.
 */

/**
 * @typedef {object} Pose  At the present frame.
 * @property {number} frame
 * @property {'keyframe' | 'draft' | 'tracked' | 'part' | 'between' | 'held' | 'opening'} source
 * @property {boolean} followed  Of a draft: found by tracking ahead, as it was found.
 * @property {string | null} stroke
 * @property {Record<string, number[]>} T  Part to camera: three rows of four.
 * @property {Record<string, Point>} points
 * @property {Record<string, Point>} angles
 * @property {Point} root
 * @property {Record<string, Axis[]>} at_limit
 * @property {Gesture | null} gesture
 * @property {{ part: string, index: number, uv: Spot }[]} corners  Of boxes, where they were put.
 */

/**
 * @typedef {object} JointAngle  One by its clinical name, left and right.
 * @property {string} joint
 * @property {string} angle
 * @property {string} label  "Knee flexion"
 * @property {string} positive
 * @property {string} negative
 * @property {{ side: 'L' | 'R' | 'C', part: string, values: Series, errors: Series | null }[]} sides  part: the one that the joint
 *   carries. errors: degrees by which a value is expected to be off; null where depth was not lifted.
 * @property {number} guess  A value that is expected to be off by more degrees is a guess.
 * @property {{ joint: string, angle: string, label: string }[]} choices
 */

/**
 * @typedef {object} PartKeyframe  Of some limbs alone.
 * @property {number} frame
 * @property {string[]} parts
 * @property {{ label: string, side: 'L' | 'R' | 'C', parts: string[] }[]} limbs  What they are called, and their colours.
 * @property {string} words  "right arm only"
 */

/**
 * @typedef {object} Segment
 * @property {number} first
 * @property {number} last
 * @property {'good' | 'check' | 'lost' | 'outdated' | 'none' | 'waiting' | 'tracking'} state
 * @property {string} words
 * @property {string} short  The same without what `todo` says.
 * @property {string} todo  What to do about it: "Go to 34", "Add a keyframe at 37".
 * @property {string | null} cause
 * @property {string | null} part
 * @property {Spot | null} frames
 * @property {number | null} go
 * @property {number | null} px  Expected error there, pixels of the video.
 * @property {number | null} cm
 * @property {string} size  The same in words.
 * @property {number | null} percent
 * @property {number | null} pass
 * @property {number | null} of
 * @property {(number | null)[]} scores
 * @property {number | null} best
 * @property {string[]} notes
 * @property {boolean} unfinished
 * @property {Spot | null} unreached
 */

/**
 * @typedef {object} ExpectedError  The largest of one part in a segment.
 * @property {number} first  Of the segment.
 * @property {string} part
 * @property {number} frame  At which it is largest.
 * @property {number} px  Of the video.
 * @property {number | null} cm  Null where the lens is a guess.
 */

/**
 * @typedef {object} ReviewPlace  A place of the motion to look at.
 * @property {string} id
 * @property {'tracked' | 'draft'} kind
 * @property {number} frame
 * @property {string | null} part  Null where it is about the whole body.
 * @property {string} label
 * @property {'L' | 'R' | 'C'} side
 * @property {string} cause
 * @property {number} first  Of the frames it is about.
 * @property {number} last
 * @property {number | null} px  Expected error; null where nobody knows.
 * @property {number | null} cm
 * @property {string} size  The same in words.
 * @property {string} reason
 * @property {Point} end  The part's far end, camera frame, metres.
 * @property {number} radius_m  The expected error, metres.
 * @property {Spot} at  The far end in the picture.
 * @property {number} crop  Side of what is shown of the picture around it, pixels.
 * @property {[number, number, number, number]} box  Around the body there: left, top, right, bottom, pixels.
 */

/** @typedef {{ frame: number, part: string, answer: 'accepted' | 'unclear' }} Answered */

/**
 * @typedef {object} Review  What there is to review.
 * @property {ReviewPlace[]} places  Without an answer, the worst first.
 * @property {Answered[]} answered  Those that still count.
 * @property {number} goal  One that this film allows, pixels.
 * @property {number[]} goals  To choose from.
 * @property {number | null} right_px  By which a joint that is right is expected to be off.
 * @property {number | null} px  Expected error of all joints in the mean.
 * @property {number | null} cm
 * @property {number} untracked  Segments that need tracking.
 */

/**
 * @typedef {object} SpaceFinding  What is not plausible in space.
 * @property {string} kind
 * @property {string} words
 * @property {string} part
 * @property {number} first
 * @property {number} last
 * @property {number} go  The frame to look at.
 * @property {'pin' | 'floor' | 'turn' | 'soften' | 'smooth' | 'level' | 'lens' | 'untwist' | 'unpin' | ''} remedy  What mends it with one press.
 * @property {number[]} [keyframes]  Those that a pin contradicts.
 * @property {number} [cm]  By how much at most.
 */

/**
 * @typedef {object} Suggestion
 * @property {number | null} frame
 * @property {string} title  What to do.
 * @property {string} detail  Why.
 * @property {string} kind
 * @property {string | null} part  That is to be looked at there.
 * @property {string | null} cause
 * @property {'forward' | 'backward' | null} ahead  The way in which tracking ahead leads on.
 */
/** @typedef {{ part: string, x: Series, y: Series, z: Series, error: Series }} Curve */
/** @typedef {{ part: string, points: [number, number, number, number][], keys: number[] }} Trail */

/**
 * @typedef {object} ProposedPin  What seems to stand still.
 * @property {string} part
 * @property {string} label  What is held: "Left foot", "Left heel".
 * @property {'L' | 'R' | 'C'} side
 * @property {string[]} landmarks  Those that are held; none: its joint, or the point.
 * @property {Point | null} point_m  In the part's frame, instead of its joint.
 * @property {number} first
 * @property {number} last
 * @property {boolean} floor  Whether it stands on the floor.
 */

/**
 * @typedef {object} Pin  A part held at one place.
 * @property {string} part
 * @property {string} label
 * @property {'L' | 'R' | 'C'} side
 * @property {string[]} landmarks
 * @property {Point | null} point_m
 * @property {number} first
 * @property {number} last
 * @property {boolean} floor
 * @property {Point[]} sole  Its outline where it was put down, in the world; none but of a foot.
 * @property {number | null} slides_cm  At most, in the motion as it was solved.
 * @property {number | null} keyframe  The one that stands against it.
 * @property {string} problem
 */

/** @typedef {{ height_m: number | null, has_feet: boolean, soles: string, soles_off_cm: number | null }} Floor
 * Along up from the camera; whether pinned feet could determine it; how soles lie on it, in words, and by how
 * much they
 *   are off at most, null without any. */
/** @typedef {{ part: string, label: string, side: 'L' | 'R' | 'C', points: Point[] }} FootPath */
/**
 * @typedef {object} Solid  A part's convex surface, in its frame, metres.
 * @property {Point[]} points
 * @property {{ points: Point[], normal: Point }[]} flats  Its flat sides.
 * @property {{ ends: [Point, Point], normal: Point }[]} wires  Lines along a round side, and its normal there.
 */

/** @typedef {{ frame: number, T: Record<string, number[]> }} Ghost  A pose: part to camera, three rows of four. */

/**
 * @typedef {object} SmallViews  They stand still in the world, so that they turn against a camera that turns.
 * @property {number[][]} top  R_view_camera.
 * @property {number[][]} side
 * @property {number[][]} front
 * @property {Point} origin  Of the world in the camera frame, metres: where the views' coordinates begin.
 */

/** @typedef {{ kind: string, first: number, last: number, words: string }} CameraFinding */

/**
 * @typedef {{ first: number, last: number, metres: number | null, off_m: number | null }} CameraWay  From its first place; what is said as ±.
 */
/** @typedef {{ frames: number[], T: number[][], zoom: number[] }} CameraPlaces  T_world_camera, 3 by 4, by rows. */

/**
 * @typedef {object} CameraMotion  How the camera turned, zoomed and moved.
 * @property {CameraWay[]} ways  How far it went, for every piece that hangs together; none of one that does not move.
 * @property {'turns' | 'moves'} kind
 * @property {string} source  The file it was imported from; empty where it was found.
 * @property {boolean} counts  False while the camera is said to stand still.
 * @property {string} words
 * @property {(number | null)[]} error_px  By frame, of the points of the background.
 * @property {number[]} keys  Frames at which a person corrected it.
 * @property {CameraFinding[]} findings
 * @property {CameraPlaces | null} path
 */

/** @typedef {{ uv: Spot[], good: boolean[] }} BackgroundPoints  Pixels of the rectified picture. */

/**
 * @typedef {object} Feet  Their ways, and the floor under them.
 * @property {number} floor_m  How far along up the floor lies from the world's origin, the camera's first place.
 * @property {number[]} frames  Those at which the motion is known.
 * @property {FootPath[]} paths  Of the soles, or of the limbs' ends, in the world; a point for every frame.
 */
/** @typedef {{ polygon: Spot[], first: number, last: number, note: string }} Mask */

/**
 * @typedef {object} Settings  How to track.
 * @property {string} method
 * @property {string} quality
 * @property {boolean | null} static_camera  Null: as it was found.
 * @property {boolean | null} found_still  Whether the camera was found to stand still.
 * @property {string | null} imported
 * @property {boolean} smooth  In space, as far as the pictures allow.
 * @property {string[]} cues  What the motion is found from.
 */

/**
 * @typedef {object} CueHere  One of all that there are.
 * @property {string} id
 * @property {string} label
 * @property {string} title
 * @property {boolean} on  Whether it is chosen.
 * @property {string} off  Why it does not count here, whatever is chosen; or ''.
 * @property {boolean} leads  Whether it leads to a motion by itself.
 */

/**
 * @typedef {object} NetworkHere  A network that finds keypoints.
 * @property {string} id
 * @property {string} label
 * @property {number} mb
 * @property {boolean} chosen
 * @property {boolean} of_animals  Whether it drafts a dog or a horse, in place of people.
 * @property {string} remedy  The command that adds it, or ''.
 * @property {number | null} frame_s  Seconds that a frame of a draft takes; null where nobody knows.
 */

/**
 * @typedef {object} Keypoint
 * @property {string} joint
 * @property {string} label
 * @property {Spot} at  Pixels of the main view.
 * @property {number} sure  From 0 to 1.
 * @property {'found' | 'corrected' | 'ignored'} state  The last two by a person.
 */

/** @typedef {{ frame: number, points: Keypoint[] }} Keypoints */

/**
 * @typedef {object} Fit  What the last fit of a pose did.
 * @property {number} frame
 * @property {string} words
 * @property {boolean} looking_back
 */

/** @typedef {{ before: number, after: number }} Difference */
/** @typedef {{ part: string, what: string, pair: boolean, before: number, after: number }} NewSize */
/** @typedef {{ part: string, deg: number }} Turned */
/** @typedef {{ frame: number, parts: Turned[] }} NewPose */

/**
 * @typedef {object} SizesPreview  New sizes that wait to be applied or discarded.
 * @property {string} words
 * @property {string} note  What several films tell; empty with one.
 * @property {number} keyframes
 * @property {Difference | null} error  Of the body's outline, pixels; null where none is seen.
 * @property {Difference} height  Centimetres.
 * @property {NewSize[]} changes  Centimetres.
 * @property {string[]} unseen  Parts whose sizes the pictures do not determine.
 * @property {boolean} poses  Whether other poses are shown with them.
 * @property {boolean} choice  Whether they fit better both with and without other poses.
 * @property {NewPose[]} turns  What other poses turn.
 * @property {number} outdated  Segments.
 * @property {boolean} looking_back
 */

/**
 * @typedef {object} FoundUp  What was found of the up direction, until something else is edited.
 * @property {string} words
 * @property {number | null} frame  In which the lines are seen; null where the camera stands still.
 * @property {[Spot, Spot][]} lines  Upright ones that agree, pixels.
 * @property {UpChoice[]} choices  Where ways disagree; none where they do not.
 */
/** @typedef {{ label: string, source: string, up: Point, sigma_deg: number }} UpChoice  In the world. */

/**
 * @typedef {object} Reduction  Keyframes of a reduction that wait to be applied or discarded.
 * @property {number} first  Of the frames with a motion.
 * @property {number} last
 * @property {number | null} from  Of the frames that were asked for; null for those of the video.
 * @property {number | null} to
 * @property {number | null} goal  One keyframe in so many frames was asked for; null for a tolerance.
 * @property {number | null} cm  The tolerance, in space or in the picture.
 * @property {number | null} px
 * @property {string[]} limbs  Names of parts whose limbs are keyed alone; none for the whole body.
 * @property {boolean} replacing  Whether keyframes that are there may go.
 * @property {'tracked' | 'drafts' | 'imported'} source
 * @property {boolean} busy  Whether what follows is of what was asked for before.
 * @property {number[]} frames  None while nothing is known.
 * @property {number} kept  How many of them are keyframes already.
 * @property {number} every  Frames from one to the next, on average.
 * @property {number | null} off_cm  How far a point of the body is off at most, interpolated alone.
 * @property {number | null} off_px
 * @property {number} gaps  Frames without a pose.
 */

/**
 * @typedef {object} DraftPlace  A frame whose draft should be confirmed.
 * @property {number} frame
 * @property {string} reason
 * @property {string[]} parts  Their labels; none where it is about all.
 */

/**
 * @typedef {object} Drafted  What the last draft of the film found.
 * @property {boolean} latest  Whether nothing was edited since.
 * @property {number} first  Of the frames drafted last.
 * @property {number} last
 * @property {number} drafted  How many of these were.
 * @property {number} behind  Of how many of these the tracked pose is shown.
 * @property {Spot[]} missing  Runs of frames, of all drafts, where nobody was found and nothing is posed or tracked.
 * @property {[number, number][]} rest  Runs of frames that it was cancelled before.
 * @property {DraftPlace[]} proposals  Those to confirm that are no keyframes yet.
 */

/**
 * @typedef {object} Job
 * @property {'idle' | 'running' | 'done' | 'cancelled' | 'failed'} state
 * @property {string} title
 * @property {string} words
 * @property {number} percent
 * @property {number | null} seconds_left
 * @property {'track' | 'fit' | 'draft' | 'ahead' | 'reduce' | 'camera' | 'space' | 'drafts' | 'film'} kind
 * @property {'good' | 'check' | 'lost' | null} worst  The verdict of its worst segment, once it has tracked some.
 */

/** @typedef {{ state: 'saved' | 'saving' | 'failed' | 'readonly', at: number, words: string }} Saved */

/** @typedef {{ label: string, frame: number, made: number | null }} HistoryStep  made: seconds since 1970. */

/**
 * @typedef {object} History  Undo and redo as a list.
 * @property {number} done  How many of all steps are done.
 * @property {number} total
 * @property {number} first  How many stand before those that are listed.
 * @property {HistoryStep[]} steps  Those around the present one, oldest first.
 */

/**
 * @typedef {object} BodyOfScene
 * @property {string} id
 * @property {string} name
 * @property {string} called  As a person calls it; empty where nobody does.
 * @property {boolean} posed
 * @property {string} colour
 * @property {number[]} keys  Frames of its keyframes.
 * @property {number} drafts  How many it has.
 * @property {number} rest  How many frames a draft was cancelled before.
 * @property {{ name: string, label: string }[]} parts
 * @property {number[]} places  Frames of a draft to confirm; of the posed body `draft` has them.
 * @property {{ first: number, last: number, state: string }[]} segments
 * @property {'good' | 'check' | 'lost' | null} worst  The verdict on its worst segment.
 * @property {number} open  How many of its segments have no verdict.
 */

/** @typedef {{ body: string, name: string, part: string, label: string }} BondEnd  name: of the body. */
/**
 * @typedef {object} Bond  Two points that meet.
 * @property {number} index  Among all of the session.
 * @property {BondEnd} holder
 * @property {BondEnd} held
 * @property {number} first
 * @property {number} last
 * @property {'both' | 'holder' | 'held'} moves
 * @property {number} apart_cm  How far apart they are at most.
 * @property {number} worst  The frame at which they are.
 * @property {boolean} meet  Whether that is no distance.
 * @property {'keyed' | 'unposed' | 'tracked' | 'untracked'} cause  Why they do not meet.
 * @property {string | null} unposed  The name of a body that has no keyframe.
 */

/** @typedef {{ frame: number, text: string }} Note  Without words a flag. */

/**
 * @typedef {object} KeptPose  Of the library of poses.
 * @property {string} id
 * @property {string} name
 * @property {string} body
 * @property {boolean} fits  Whether the present body has any of its parts.
 * @property {PoseStroke[]} strokes  Those behind first, in a field of 100 × 100.
 */
/** @typedef {['L' | 'R' | 'C', number, number, number, number, number]} PoseStroke  Side, x0, y0, x1, y1, width. */

/**
 * @typedef {object} Sections  The newest of each section; null while nothing is open.
 * @property {File | null} file
 * @property {Camera | null} camera
 * @property {Film[]} films  The views after the first.
 * @property {FilmsSeen | null} films_seen  Null where there is one film, or nothing is known of the motion.
 * @property {Surface | null} surface
 * @property {SmallViews | null} views  Of the camera at the present frame.
 * @property {CameraMotion | null} camera_motion  Null where the camera stands still or nobody looked.
 * @property {number[] | null} camera_here  T_world_camera of the present frame, 3 by 4, by rows.
 * @property {BackgroundPoints | null} background  Null while they are not shown, or nobody kept them.
 * @property {Body | null} body
 * @property {Looks | null} view
 * @property {Pose | null} pose
 * @property {{ frames: number[], drafts: number[], soft: number[], parts: PartKeyframe[] }} keys
 * @property {Segment[]} segments
 * @property {ExpectedError[]} errors  The worst parts of every segment, the worst first.
 * @property {Review | null} review
 * @property {SpaceFinding[]} space  The worst first.
 * @property {Suggestion | null} suggest
 * @property {Series} need  Pixels that a keyframe is expected to mend.
 * @property {Record<string, Series>} lanes  How much the picture shows of a part, 0 to 1.
 * @property {Curve | null} curve
 * @property {JointAngle | null} joint_angle
 * @property {Trail | null} trail
 * @property {Pin[]} pins
 * @property {ProposedPin[]} proposed_pins  Neither accepted nor dismissed.
 * @property {(Spot | null)[]} still  The frames between which each pin's part stands still.
 * @property {Floor | null} floor
 * @property {Feet | null} feet
 * @property {Ghost[]} ghosts  The keyframes beside the present frame, where ghosts are shown.
 * @property {Record<string, Solid> | null} solids  Of every part.
 * @property {BodyOfScene[]} bodies  All of the scene.
 * @property {Bond[]} bonds  Those that hold the posed body.
 * @property {Record<string, Record<string, Solid>>} solids_beside  Of each body that is not posed, by its id.
 * @property {Record<string, Record<string, number[]>>} poses_beside  T of its parts, likewise.
 * @property {{ solids: Record<string, Solid>, T: Record<string, number[]> } | null} before  The body that new sizes are compared with.
 * @property {Mask[]} masks
 * @property {Settings} settings
 * @property {CueHere[]} cues
 * @property {NetworkHere[]} networks
 * @property {Keypoints | null} keypoints  Of the present frame; null where none are known.
 * @property {Fit | null} fit
 * @property {FoundUp | null} up
 * @property {SizesPreview | null} sizes_preview
 * @property {Reduction | null} reduction
 * @property {Drafted | null} draft
 * @property {{ frame: number, boxes: [number, number, number, number][] | null } | null} people  Who is in the picture of the present
 *   frame, the tallest first; null where nobody has looked, boxes null where that was not done to the end.
 * @property {Job} job
 * @property {Saved} saved
 * @property {{ undo: string | null, redo: string | null }} undo
 * @property {History | null} history
 * @property {Note[]} notes  By frame.
 * @property {boolean} clipboard
 * @property {KeptPose[]} poses
 * @property {{ first: boolean, done: Record<string, boolean> }} guide
 * @property {number} tabs
 * @property {[number, number][]} damage  First and last of every run of frames that are not tracked by.
 * @property {string} server  Another after every start.
 * @property {string} revision  Of the document: which edit it came from, if an edit.
 * @property {number} done  The number of the last message of this page that was done or refused.
 * @property {number} ack  And of the last whose outcome is on the disk.
 */

/**
 * @typedef {object} Recent  A session opened lately.
 * @property {string} id
 * @property {string} name
 * @property {string} path
 * @property {string} video
 * @property {number} keyframes
 * @property {number} frames
 * @property {[string, number][]} strip
 * @property {number} opened_at
 * @property {string} thumb
 * @property {boolean} missing
 * @property {boolean} exchanged
 */

/**
 * @typedef {object} FoundFile
 * @property {string} id
 * @property {string} kind
 * @property {string} name
 * @property {string} folder
 * @property {number} bytes
 * @property {number} count
 * @property {number} modified_at
 */

/**
 * @typedef {object} Library  What can be opened.
 * @property {Recent[]} recents
 * @property {{ id: string, words: string, thumb: string }[]} samples
 * @property {FoundFile[]} files
 * @property {boolean} more
 * @property {string[]} folders
 * @property {string[]} suffixes
 * @property {number} largest_upload
 */

/** @typedef {{ id: string, name: string }} Folder */
/** @typedef {{ way: Folder[], folders: Folder[], files: any[], more: boolean }} FolderListing */

/**
 * @typedef {object} Message  A toast; one with a button waits for an answer, unless it is brief.
 * @property {string} words
 * @property {string} [kind]
 * @property {{ label: string, send?: object, run?: () => void }} [button]
 * @property {boolean} [brief]
 * @property {number} [edit]  The message to the server that it tells of.
 */

/** @typedef {Message & { id: number, path: string | null, at: number, until: number, wasNewest?: boolean }} Toast */

/** @typedef {{ path: string, id: string, name: string }} Place  Where a session lies. */
/** @typedef {{ client: string, why: string, file: Place | null, count: number }} UnsentEdits */

/**
 * @typedef {object} Ui  This tab's own.
 * @property {string} tool
 * @property {string} layout
 * @property {string} tab  Of the inspector.
 * @property {string} chart
 * @property {boolean} lanes
 * @property {string | null} hover  The part below the pointer.
 * @property {boolean} dragging
 * @property {boolean} playing
 * @property {boolean} connected
 * @property {UnsentEdits[]} [unsent]  What waits for a decision.
 * @property {string[] | null} [limb]
 * @property {number | null} [mask]  The region that is being edited.
 * @property {[number, number, number, number] | null} [box]  Around the person: left, top, right, bottom, pixels of the video.
 * @property {[number, number, number, number] | null} [personHover]  Of the people found, the one below the pointer.
 * @property {string} [lookedAt]  The film and frame in which people were looked for last.
 * @property {[number, number] | null} [draftRange]  First and last frame to draft; null: all.
 * @property {boolean} [rings]  Whether keypoints are drawn, once somebody chose; else they are beside the Track tab.
 * @property {boolean} [personMask]  Whether the network's mask of the person is drawn.
 * @property {string | null} [keypointHover]  The joint that is pointed at in the list.
 * @property {boolean} [allKeypoints]  The list shows all of them.
 * @property {string} [draftRead]  The revision whose draft's banner was closed.
 * @property {string | null} [bodyNaming]  The body whose name is being typed.
 * @property {string | null} [filmLarge]  The other film that stands beside the first.
 * @property {{ id: string, frame: number } | null} [filmHeld]  The other film whose picture is held, and its frame.
 * @property {{ anchor: string, place: number[] } | null} [sight]  The joint that is dragged in a film's picture,
 *   and where its camera stands.
 * @property {number} [shown]  The frame whose picture is on the screen.
 * @property {number} [unreadable]  The frame that turned out last to have no picture.
 * @property {boolean} [placeSeen]  Whether the frame of the place that is reviewed is on the screen.
 * @property {string | null} [menu]
 * @property {boolean | null} [sheet]  Of keys.
 * @property {string | null} [search]  The command search is open: for all, or for one kind of entries.
 * @property {string | null} [seek]  The section of the inspector that is to be brought into sight.
 * @property {number | null} [note]  The frame whose note is being written.
 * @property {boolean} [space]  The space bar is down.
 * @property {boolean | 'add'} [dropping]  'add': a film would be added to the open session.
 * @property {boolean} [flat]  There is no WebGL.
 * @property {boolean} [painted]  The page itself paints the body over the film.
 * @property {boolean} [flatRead]
 * @property {string | null} [readOnlyRead]
 * @property {string | null} [line]  Since when the server does not answer: lost, long, ended.
 * @property {boolean} [turnedAway]  Somebody answers who does not know this browser.
 * @property {boolean} [returning]  The session that was open at the server before is being opened again.
 * @property {(Job & { kind: string }) | null} [ended]
 * @property {string} [theme]
 * @property {boolean} [filterMotion]  Saved motion is low-pass filtered.
 * @property {Importing | null} [importing]  The file that is being imported, while the dialog is open.
 * @property {Exporting | null} [exporting]  What is chosen in the dialog of exports, while it is open.
 * @property {{ id: string, what: string, done: number, of: number } | null} [exportJob]  The export under way.
 * @property {Record<string, string>} [exportMissing]  What cannot be exported here, with what mends it.
 * @property {Library | null} [library]
 * @property {{ kind: string, lost: Recent | null } | null} [chooser]
 * @property {string | null} [renaming]  The session whose name is being changed.
 * @property {string} [find]
 * @property {string} [fileFind]
 * @property {FolderListing} [place]  The folder that the file chooser stands in.
 * @property {{ by: 'name' | 'size' | 'date', down: boolean }} [fileSort]
 * @property {{ name: string, loaded: number, total: number } | null} [upload]
 * @property {Toast[]} [toasts]
 * @property {number | null} [guideStep]
 * @property {Set<string>} [pulled]
 * @property {string} [lens]
 * @property {number} [lensKind]  The kind of camera that was chosen.
 * @property {'film' | 'hand' | 'thing'} [guidePath]
 * @property {boolean} [allFreedoms]
 * @property {boolean} [fitFocal]
 * @property {boolean} [orbited]  The free view was turned at least once.
 * @property {boolean} [allSizes]  Whether new sizes that hardly change are listed too.
 * @property {string | null} [figureHover]
 * @property {number} [segmentFirst]
 * @property {Set<string>} [freeAxes]
 * @property {Axis} [curveAxis]
 * @property {number} [timeHead]
 * @property {any} [timeGrabbed]
 * @property {any} [timeHover]
 * @property {boolean} [copiedHere]  What was copied last is not on the browser's clipboard.
 * @property {number} speed  Of playing, 1 as it was filmed.
 * @property {number} shuttle  How many times as fast, while it plays; negative: backward.
 * @property {boolean} loop
 * @property {{ first: number | null, last: number | null }} span  In and out point.
 * @property {number[]} [timeKeys]  Frames of the keyframes that were selected.
 * @property {number | null} [timePin]  The pin whose bar was clicked.
 * @property {Set<string>} [timeOpen]
 * @property {number} [timeScroll]
 * @property {{ width: number, height: number }} [timeSize]
 * @property {{ first: number, last: number }} [timeWindow]
 * @property {'shown' | 'over' | null} [zoomHint]
 * @property {ReviewList | null} [review]  Null while nothing is reviewed.
 * @property {number | null} [reviewGoal]  As somebody chose it, pixels.
 * @property {boolean} [reviewLeft]  It was closed before its end.
 * @property {boolean} [reviewDone]  The places that were answered are listed.
 * @property {string | null} [reviewHeld]  A row that keeps its height while the pointer is on the list.
 * @property {boolean} [allInSpace]  All that is not plausible in space is listed, not the worst alone.
 */

/** @typedef {'accepted' | 'corrected' | 'unclear'} Answer  To a place of a review. */

/**
 * @typedef {object} ReviewList  What is reviewed, and what was answered.
 * @property {ReviewPlace[]} rows  As they were ranked last; answered ones stay among them until the next N.
 * @property {string | null} current  The row's id; null where nothing is left.
 * @property {{ id: string, frame: number, label: string, answer: Answer }[]} done  In the order of the answers.
 * @property {{ id: string, answer: Answer, n: number } | null} [asked]  On its way, with the number of its message.
 * @property {{ id: string, words: string } | null} [refused]  The answer that was refused last, and why.
 */

/**
 * A file that is being imported.
 * @typedef {object} Importing
 * @property {'reading' | 'choosing' | 'importing' | 'failed'} stage
 * @property {string} id  Empty until the server has it.
 * @property {string} name
 * @property {Recognised | null} found
 * @property {string} words  Why it could not be read or imported.
 * @property {number} done
 * @property {number} of
 * @property {Record<string, any>} choices  By option the text of its value.
 */

/**
 * What a file holds, as `app/export/recognising.py` says it.
 * @typedef {{ kind: 'motion' | 'keypoints' | 'camera', program: string, facts: any }} Recognised
 */

/**
 * What is chosen in the dialog of exports: what, and for each kind the texts of its options.
 * @typedef {{ what: string, format: string, values: Record<string, Record<string, any>> }} Exporting
 */

/** @typedef {keyof Sections | `u:${keyof Ui}`} Watched  What a room can watch. */

export {};
