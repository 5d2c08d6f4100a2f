"""The lexicon: the closed sets of words that are known by hand, with one home for each concept.

With a few hundred commands most of these words occur too rarely to learn what they mean. Open
classes, such as nouns for things, are left to word similarity
(:mod:`g3.language.similarity.word_similarity`).

A set of `words` holds lower-case words as they are written
(:func:`g3.language.lexicon.field_words.bare`). A set of `stems` holds the normal forms that
:func:`g3.language.lexicon.field_words.normalise` gives, so that it also has the words' other
endings.
Where one set has more words than another for the same concept, it is built from it.
"""

from __future__ import annotations

from math import pi
from typing import Literal, get_args

from g3.groundings import Colour
from g3.language.lexicon.stemming import stem


def words(text: str) -> frozenset[str]:
    """Words that are written in one line."""
    return frozenset(text.split())


def stems(text: str) -> frozenset[str]:
    """Normal forms of words that are written in one line."""
    return frozenset(map(stem, text.split()))


def counted(text: str, *, first: int) -> dict[str, int]:
    """The numbers of words that are written in one line in their order."""
    return {word: n for n, word in enumerate(text.split(), start=first)}


# Where things are

NEAREST_WORDS, FARTHEST_WORDS = "nearest closest", "farthest furthest"
NEARER_WORDS = "closer"
BETWEEN_WORDS = "between inbetween"

Concept = Literal[
    "left", "right", "front", "back", "on", "between", "near", "far", "to", "from", "first", "last"
]
"""What closed-class words say of space and order."""
CONCEPTS: tuple[Concept, ...] = get_args(Concept)
CONCEPT_WORDS: dict[Concept, str] = {
    "left": "left leftmost left-most leftward leftwards left-hand counterclockwise "
    "counter-clockwise anticlockwise anti-clockwise ccw",
    "right": "right rightmost right-most rightward rightwards right-hand clockwise cw",
    "front": "front infront ahead forward forwards before facing",
    "back": "behind back rear backward backwards reverse",
    "on": "on onto upon atop top aboard",
    "between": f"{BETWEEN_WORDS} middle midway center centre among amid",
    "near": f"next near {NEAREST_WORDS} beside besides by close {NEARER_WORDS} nearby alongside "
    "adjacent side",
    "far": f"far distant farther further {FARTHEST_WORDS} outside opposite",
    "to": "to toward towards into onto until approach reach at",
    "from": "from off out away leave",
    "first": f"first {NEAREST_WORDS}",
    "last": f"last end {FARTHEST_WORDS}",
}
"""Words of each concept.

:func:`g3.language.lexicon.concepts.concepts` looks them up by their stems.
"""

SIDES: frozenset[Concept] = frozenset({"left", "right", "front", "back"})
"""Concepts of the sides of a thing."""
BESIDE = SIDES | {"near", "between"}
"""Concepts by which something stands beside a thing, on the ground."""
WAYS = SIDES | {"around"}
"""Concepts of ways that the robot can go without a landmark, and around."""

MENDED = words(
    "above alongside among barrel barrels behind below beneath beside between boxes closer crate "
    "crates floor fork forks forklift from ground inside into near nearby onto opposite outside "
    "package packages pallet pallets past platform receiving sideways skid skids storage there "
    "tire tires toward towards trailer trailers truck trucks under until with"
)
"""Words that are known misspelt, too, besides those of `WORD_CLASSES`: "palllet"."""

BEHIND = stems("behind")
"""The far side of a thing. The concept "back" is also a thing's own rear."""
REAR = stems("back rear")
"""Of things alike without a landmark, "the one in the back" is the farthest."""
LATERAL = stems("next beside alongside by")
"""Next to a thing of a row, in line with the row; what is "near" it may be anywhere about it."""
NEXT_TO = LATERAL | stems("near close nearby adjacent")
"""Not far from something, on whatever side."""
BETWEEN = stems(f"{BETWEEN_WORDS} among")
"""With landmarks on both sides. The concept "between" has nouns, too: the middle, the centre."""
ENDS = stems("end outside")
"""The end of a row."""
AROUND = stems("around round circle u-turn")
NEARER = stems(f"{NEARER_WORDS} nearer")
"""Some of the way towards something."""
NEAREST = stems(NEAREST_WORDS)
FARTHEST = stems(FARTHEST_WORDS)
DISTANT = stems("far away distant further farther")
"""With "from" these tell of things that are not near: "the crate far from the truck"."""
STRESSED = stems("in next beside by behind near there")
"""After "right" these are stressed by it, and it names no side: "right in front of you"."""

PLACE_PREPOSITIONS = words(
    "to toward towards into onto until on upon atop in at by near next beside besides behind "
    "before between from off front under over alongside against past around"
)
"""Words before a place, whose noun is rarely what is handled."""

# Order and number

ORDINALS = {
    **counted("first second third fourth fifth sixth seventh eighth ninth tenth", first=1),
    **counted("1st 2nd 3rd 4th 5th 6th 7th 8th 9th 10th", first=1),
}
"""The number that a word counts to."""
CARDINALS = counted("zero one two three four five six seven eight nine ten eleven twelve", first=0)
FRACTIONS = {"half": 0.5, "quarter": 0.25, "quarters": 0.25}
NUMBERS = {
    **CARDINALS,
    **counted("thirteen fourteen fifteen sixteen seventeen eighteen nineteen", first=13),
    **{
        word: 10 * n
        for word, n in counted(
            "twenty thirty forty fifty sixty seventy eighty ninety", first=2
        ).items()
    },
    **FRACTIONS,
    "hundred": 100,
    "couple": 2,
    "few": 3,
}
"""What number words say; of a few about so many."""
COUNTS = CARDINALS | {"both": 2, "pair": 2}
METRES = {
    **dict.fromkeys(("m", "meter", "meters", "metre", "metres"), 1.0),
    **dict.fromkeys(("ft", "foot", "feet"), 0.3048),
    **dict.fromkeys(("yd", "yard", "yards"), 0.9144),
    **dict.fromkeys(("inch", "inches"), 0.0254),
    **dict.fromkeys(("cm", "centimeter", "centimeters", "centimetre", "centimetres"), 0.01),
}
"""Units of length."""
AN, WHOLE = words("a an"), words("full whole complete")
"""These count one of a unit: "a metre", "a full turn"."""
SECONDS = {
    **dict.fromkeys(("s", "sec", "secs", "seconds"), 1.0),
    **dict.fromkeys(("min", "mins", "minute", "minutes"), 60.0),
}
"""Units of time."""
RADIANS = dict.fromkeys(("degree", "degrees", "deg", "degs", "°"), pi / 180)
"""Units of angle."""
CIRCLES = dict.fromkeys(("turn", "turns", "circle", "circles", "rotation", "rotations"), 2 * pi)
"""Nouns of which a number, or a part, tells an angle: "a quarter turn"."""
QUANTIFIERS = words(
    "all both each every any some several many few no most either neither everything anything "
    "something nothing"
)
UNIVERSAL = words("all both each every everything")
"""Words that speak of each thing of a kind."""
DISTRIBUTIVE = words("each every both")
"""Words before a landmark that takes one thing each."""
EVERYTHING = stems("everything stuff stock goods freight cargo lot thing")
"""Words that don't tell the kind of a load."""
HEAPED = stems("tire tyre wheel box brick block stone bag sack accessory part goods supplies")
"""Nouns whose plural may name a single load, a pallet of them."""
EXCEPTING = words("but except exception excepting excluding besides bar save")
"""Words before what is left out: "all but the red one"."""
RECIPROCAL = words("other another")
"""Words that end "each other" and "one another"."""
SINGLE = words("a an another each every either neither this that one")
"""Before a noun these speak of one thing."""
SINGULAR = words("it its itself this that one other another bus gas lens")
"""Nouns and pronouns for one thing, whatever their ending."""
PLURAL = words(
    "they them these those their ones others both all two three four five six seven eight nine "
    "ten several many few most men women people children feet shelves everything"
)
"""Nouns and pronouns for several things, whatever their ending."""
ROWS = words("row line column series")
"""Nouns for things that stand in a row."""
COLLECTIVES = ROWS | words("group pair couple stack pile cluster bunch collection rest remainder")
"""Nouns that stand for several things: "the row of pallets"."""

# Who and what is spoken of

ARTICLES = words("the a an")
INDEFINITE = words("a an another any some each every one no")
"""Before a noun these don't speak of what was spoken of before."""
OWNERS = words("its their")
"""Before a noun these speak of a part of what was spoken of before: "its bed"."""
DECKS = stems("bed deck")
"""Nouns for what a load is put on, of a vehicle that was spoken of: "above the bed"."""
YOU = words("you your me my")
"""Who is spoken to, as the landmark of a way or a side: "to your left"."""
ROBOT = words("you yourself me myself i we us robot")
"""Nouns for the robot. These are grounded in it; "your" isn't."""
SELVES = words("itself themselves")
REFLEXIVES = SELVES | words("himself herself")
THESE = words("this that these those")
"""Demonstratives: "this table" is one that was spoken of."""
_PERSONAL = words("him her he she")
PERSONAL = _PERSONAL | words("himself herself")
IT = words("it them they itself em") | PERSONAL
"""Pronouns that the search grounds as their antecedents are."""
PRONOUNS = IT | THESE | SELVES | _PERSONAL
"""Words that stand for something spoken of before, as their clause's noun."""
DEMONSTRATIVES = THESE | words("said")
AGAIN = words("then also too likewise same well ditto")
"""Words by which the same is said of something else: "then the crate", "the crate as well"."""
OTHERS = words("other another")
"""Something else than what was meant before: "the other truck"."""
START = words(
    "to at in on back here there where you ye u your yer the this same that it spot place position "
    "point location are were was is be now then been started start starting began begin current "
    "present original first initial again right me i my we came from stand standing sitting put "
    "stationary still over of after came home s 're re off along"
)
"""Words of which places are made where the robot was when it was told: "back to your spot"."""
RETURNING = words(
    "come comes go get head return returning resume drive roll run back again here there over right"
    " then and"
)
"""Words of a clause that sends the robot back."""
BACK = words("back return returning resume started began came")
"""Words that say that the robot has been there."""
HOLDING = words("keep keeping hold holding hang hanging on onto of to still it up")
"""Words of a clause that keeps a load on the forks."""
ORBITING = words("around round lap circle circuit")
"""Words of a way around something."""
LAPS = stems("lap circuit circle loop round run tour")
"""Nouns for such a way: "a lap around the truck"."""
REST = OTHERS | words("others rest remainder remaining")
"""Nouns for what else there is of a kind."""
ONES = words("one ones")
NOUNLESS = ONES | words("other others")
"""Heads that leave out their noun: "the empty one"."""
PEOPLE = words(
    "person people man woman human worker pedestrian guy lady fellow fella bloke chap gentleman "
    "employee colleague somebody someone dude buddy lad lass boy girl kid"
)
"""People, who are no loads."""
DRIVERS = words("operator driver")
"""Who drives the robot, and so is told what to do."""
PERSONS = PEOPLE | DRIVERS | PERSONAL
"""People, as commands have them."""
HEAPS = words("berm mound heap hill bank ridge embankment")
"""Heaps of earth: nothing is put on top of them."""
NO_ANTECEDENTS = words(
    "you your yourself me i we us my anything something everything nothing forward left right "
    "back bit degrees feet inches meters metres"
)
"""Nouns that no pronoun stands for."""

# What things are like

EMPTY = words("empty unloaded vacant bare")
LADEN = words("loaded full laden occupied nonempty non-empty")
HAVING = words("with has have having got carrying holding bearing")
"""Before what stands on a thing: "the truck with the tires on it"."""
HELD = words("have having got carry carrying hold holding")
"""What the robot does with its load: "the crate that you are holding"."""
OPTION = words("number option")
LISTING = OPTION | words("the a of them those these one ones please i mean it s is just")
"""Words of answers that pick from a list: "number 2", "both of them"."""
NONE_OF_THEM = words("neither none no nope nothing")
WHICHEVER = words("any either whichever whatever")
NOTHING = words("nothing none")
ALONE = stems("alone lone lonely single solitary isolated")
FORMER = words("old original previous former initial starting")
"""Where something was at first: "its old position"."""

COLOUR_WORDS: dict[Colour, str] = {
    "black": "black ebony jet",
    "white": "white ivory",
    "grey": "grey gray silver charcoal",
    "red": "red crimson scarlet maroon ruby burgundy vermilion",
    "green": "green lime emerald olive",
    "yellow": "yellow golden amber",
    "blue": "blue navy azure cyan teal turquoise aqua",
    "brown": "brown tan beige chestnut",
    "orange": "orange",
    "pink": "pink rose",
    "purple": "purple violet indigo lilac lavender mauve magenta",
}
"""Words of each colour."""

Dimension = Literal["height", "length", "width", "volume"]
"""What of a thing's size words can say."""
SIZE_WORDS: dict[tuple[Dimension, int], str] = {
    ("height", 1): "tall taller tallest",
    ("height", -1): "short shorter shortest flat flatter flattest",
    ("length", 1): "long longer longest",
    ("length", -1): "short shorter shortest",
    ("width", 1): "wide wider widest broad broader broadest",
    ("width", -1): "narrow narrower narrowest slim slimmer slimmest thin thinner thinnest",
    ("volume", 1): "big bigger biggest large larger largest huge giant enormous massive",
    ("volume", -1): "small smaller smallest little littlest tiny tinier tiniest mini",
}
"""Adjectives of size: 1 for much of a dimension, -1 for little. What is short may be either."""

TELLING = stems("other another same this that empty full loaded single lonely only") | stems(
    " ".join(SIZE_WORDS.values())
)
"""Adjectives that tell things of a kind apart, whatever a map says of them."""
FORKS = stems("fork forks")
LIFTS = stems("forklift lift prong tine arm")
"""Nouns for the robot by what lifts: "raise your forklift" moves its forks."""
FLOOR = stems("ground floor pavement")
AREAS = FLOOR | stems("area space spot place gap slot location position region zone bay aisle")
"""Nouns for places."""
GENERIC = stems(
    "thing object item load goods cargo stuff freight material unit piece content supply batch set "
    "lot line"
)
"""Nouns that may stand for whatever there is."""
ASIDE = words("left right front back rear")
"""Nouns for where a thing is, not for what it is by: "in the back"."""
HANDS = words("hand shoulder")
"""Nouns that a side may stand before, where it is of who looks there: "your left shoulder"."""
STRESSING = words("the very far extreme absolute")
"""What may stand before them."""
PARTS = words("end side part half corner space spot area slot")
"""Nouns for parts of things."""

# Verbs

VERBS = words("placing taking carrying going turning staying")
"""Classes of verbs, by what they ask for."""
HANDLING_VERBS = words("placing taking carrying")
"""Those of them that handle something."""
FILLING = words(
    "load loading fill filling stack stacking stock stocking pack packing pile piling heap heaping "
    "cram stuff"
)
"""Verbs that have what is filled first: "load the truck with the tires"."""
STACKING = stems("stack pile heap")
"""Verbs that put a load on top of another one."""
UNLOADING = words("unload unloading offload offloading")
"""Verbs whose object is what is emptied, or what comes off it."""
EMPTYING = UNLOADING | words(
    "empty emptying clear clearing strip stripping rid relieve relieving unburden disburden free "
    "drain"
)
"""Verbs that have what is emptied first: "clear the truck of tires"."""
SENDING = stems("deliver delivery transfer ship send return forward relocate dispatch")
"""Verbs that say where something is in the end, not on the way: "deliver it to the truck"."""
LIGHT = words(
    "make making do doing take taking give giving perform performing execute executing have hang"
)
"""Verbs that leave what to do to a noun: "make a left turn"."""
NOMINALS = {
    **dict.fromkeys(("pickup", "pick-up", "removal", "retrieval", "collection"), "taking"),
    **dict.fromkeys(("drop-off", "dropoff", "placement", "deposit", "unloading"), "placing"),
    **dict.fromkeys(("delivery", "transport", "relocation", "ride"), "carrying"),
    **dict.fromkeys(("trip", "approach"), "going"),
    "u-turn": "turning",
    "about-turn": "turning",
    "rotation": "turning",
}
"""Nouns for what verbs of a class do, other than these verbs themselves: "a lift"."""
ASKING = stems("need want require")
"""These ask for what they have as their object: "we need the crate on the truck"."""
KEEPING = words("keep keeping")
"""Verbs that put a thing somewhere where a place follows, in English as it is spoken in India."""
MOVING = words("move moving return returning pull pulling")
"""Verbs of moving the robot, where they are about nothing else: "pull out"."""
GETTING = words("take taking get getting")
BRINGING = GETTING | words("remove removing pull pulling")
"""Verbs of taking that may also say where to: "get the crate next to the truck"."""
SWAPPING = stems("swap switch exchange trade")
"""Verbs by which two things change places."""
LEAVING = words("leave leaving")
RAISING = words("raise raising lift lifting elevate elevating hoist hoisting")
LOWERING = words("lower lowering drop dropping")
"""Verbs that move the robot's forks."""
FACING = words("face faces facing point pointing aim")
ALIGNING = words("align aligning aligned")
LINING = words("line lines lining lined")
"""Of "line up"."""
PARKING = words("park parking")
PASSING = words("past pass passing beyond")
"""By something and on."""
LEADING = stems(
    "be am is are was re have has had do does did will would shall should can could may might must "
    "need want wish like love prefer try attempt begin start continue proceed keep resume go come "
    "get prepare make ensure remember help let use ask tell say want expect manage plan decide"
)
"""Verbs that lead on to the verb that says what to do: auxiliaries, and verbs of beginning, trying,
wanting and helping. "Go" and "get" say what to do where no other verb follows."""
LINKING = words("to and by ready sure going able about supposed on in order")
"""Words between such a verb and the one that it leads on to: "get ready to lift"."""
REGARDING = stems(
    "see look watch notice spot find observe check mind avoid miss touch hit bump beware know "
    "remember wish hope think hear listen say tell thank appreciate hurry rush"
)
"""Verbs of seeing, avoiding and saying, which handle nothing."""
PHRASAL_VERBS = {
    (stem(verb), particle): classes
    for phrase, classes in (
        ("let down", "placing"),
        ("let go", "placing"),
        ("load up", "taking+carrying"),
        ("pull up", "taking+going"),
        ("pull over", "going"),
        ("line up", "placing+going"),
    )
    for verb, particle in (phrase.split(),)
}
"""Verbs with a particle that are of other classes than the verb alone."""
EXISTENTIAL = words("there here is are was were 's s 're re")
"""Words that say that something is there: "there are two crates"."""
CLOSING = words("that 's s is it all")
"""Words that say that a command is at its end: "that's it"."""
STATING = words("is are was were 's s 're re has have had seems looks")
"""Verbs that say how the thing is that they have as their subject."""
PAST = words("was were")
"""Words that begin what has been done to something, which nobody asks for."""
QUESTIONS = words("what why who")
"""Words that begin questions, which ask for nothing: "what are you waiting for"."""
ABOARD = words("on onto upon in into up to")
"""Words that lead onto the robot, before a word for it: "load it onto your forklift"."""
INTERJECTIONS = words("hey hi hello alright well yo um uh oh yeah")
"""Words that only call for attention."""
PURPOSES = words("so to order")
"""Words that begin what something is done for: "so that you face the truck"."""

# Typing

SHORT_FORMS = {
    "u": "you",
    "ur": "your",
    "ya": "you",
    "em": "them",
    "r": "are",
    "n": "and",
    "thru": "through",
    "til": "till",
    "teh": "the",
    "hte": "the",
    "adn": "and",
    "nxt": "next",
    "ontop": "top",
    "wit": "with",
    "farest": "farthest",
}
"""Words that people type or say shorter, and slips in words too short to be mended."""
CONTRACTED = {"re": "are", "ve": "have", "ll": "will", "d": "would", "em": "them", "til": "till"}
"""What stands after an apostrophe."""
ABOUT = words(
    "about around approximately approx roughly maybe perhaps like some or so exactly just only by "
    "for to of on at the side spot way place more further another extra bit little say big"
)
"""What may stand around a measure: "for about ten metres", "on the spot"."""
STRAIGHT = words("straight fwd onward onwards on")
"""Words for going on without a turn."""
WHEN = words("when once after")
"""What begins a clause that says what has been done before."""
LATER = words("then now will")
"""Words for what is so after the steps before: "the crate that is then on your left"."""
ARROWS = words("-> --> => ==> → ⇒ ➜")
"""Signs that are read as "to"."""

# Clauses

_UNTIL = "until till when"
UNTIL = words(_UNTIL)
"""Before what is to be reached."""
SENTENCE_ENDS = frozenset(".!?;")
NOT_IMPERATIVE = words(
    "the a an this that these those it they them he she we i you your my its one two three there "
    "in on at to from of off with by near next behind between under over onto into when if while "
    "once after before until so as do don't dont don did does can could would will should shall "
    "may might must never not no is are be was were am who what where which why how"
)
"""Words that begin fragments, questions, statements and negations."""

WORD_CLASSES = {
    "placing": "put place set drop deposit lay leave lower position stack stand park release "
    "unload offload discharge dump rest store stow stash settle line arrange insert install mount "
    "hang stick tuck shove slap sling chuck toss plop plonk plunk perch nestle",
    "taking": "pick take get grab lift raise remove fetch collect retrieve grasp hoist pull "
    "seize hold unload offload discharge detach extract gather acquire snag nab scoop heave "
    "elevate",
    "carrying": "move bring carry transfer transport haul deliver relocate shift push load "
    "return drag ship convey shuttle send lug slide run ferry tote schlep",
    "going": "go drive head proceed travel continue advance approach come walk roll pass cross "
    "enter exit leave back reverse follow reach navigate steer maneuver cruise retreat zip scoot "
    "mosey",
    "turning": "turn spin rotate swing swerve pivot swivel face veer circle twist",
    "staying": "stop wait stay halt pause remain keep stand hold idle park freeze bide chill",
    "side": "left right front rear back side middle center centre end corner edge top bottom "
    "leftmost rightmost far near north south east west",
    "way": "forward forwards backward backwards ahead straight up down around over off away out "
    "back across along past through leftward rightward left right sideways",
    "measure": "foot feet ft meter meters metre metres inch inches degree degrees bit little "
    "square squares slot slots length lengths width yard yards unit units spot spots half",
    "order": "first second third fourth fifth last next nearest closest furthest farthest other "
    "leftmost rightmost only",
    "negating": "not n't nt never without",
    "counting": "all both each every any some half",
    "exactly": "directly just right immediately slightly exactly straight all somewhat "
    "approximately about almost well further",
    "being": "is are was be being been located sitting standing situated placed resting",
    "relative": "that which who",
    "until": f"{_UNTIL} while once after before if so as like",
    "polite": "please kindly now ok okay then first next finally",
    "you": "you your yourself i me my we us",
    "it": "it them they one ones its their itself",
}
"""Classes of words that decide how a command is built: verbs by what they take (a place, a source,
a way), words of direction, words that measure.
:func:`g3.language.lexicon.verb_classes.word_class` looks them up."""
RELATIVE = words(WORD_CLASSES["relative"])
"""Words before what tells of a thing: "the crate that is on the truck"."""
