/* The protocol by which scans become one map, and replicas of the map stay whole: laser_publisher with ray_selector, the
 * matcher, and the owner of the map, in lockstep, with what a network and a forger may do to them.
 *
 * The code: services/laser_publisher/main.cpp (PublishUntilMapped), services/stages/matcher_stage.cpp (Answer),
 * services/map_updater/main.cpp (Answer, AnswerRequest), services/map_updater/pages.cpp (MakePage),
 * services/replica/map_replica.cpp and delta_reader.cpp.
 *
 * A scan is a number from 1, a version of the map the number of scans in it. The content of a tile is the version that
 * has changed it last. Pages have room for one tile. Messages may be lost, come twice or overtake others, as often as
 * the budgets allow; the matcher may be killed and started again, and so may the owner, whose map comes back from its
 * journal; a power cut may take the last scan from the journal. The forger asks for pages in the matcher's name.
 * Matches, deltas and pages cannot be forged: their senders are known (services/bus/sole_sender.hpp).
 *
 * Checked: a matcher that believes that it holds a version holds all of that version; the owner takes each scan once,
 * and in order; and the last scan is answered, whatever happens: nothing waits for ever, or goes round for ever. */

#ifndef SCANS
#define SCANS 2
#endif
#ifndef LOSSES
#define LOSSES 1
#endif
#ifndef DOUBLES
#define DOUBLES 1
#endif
#ifndef KILLS
#define KILLS 1
#endif
#ifndef POWER_CUTS
#define POWER_CUTS 0
#endif
#ifndef FORGED
#define FORGED 1
#endif

#define TILES 2
#define VERSIONS (SCANS + 1)
#define NONE 15    /* no tile, no version */
#define WRONG 14   /* what a tile becomes when a change meets other content than that which it was made for */
#define TILE(epoch, version, tile) (((epoch) * VERSIONS + (version)) * TILES + (tile))

chan rays_to_matcher = [2] of { byte };                /* scan */
chan rays_to_owner = [2] of { byte };                  /* scan */
chan matches = [2] of { byte };                        /* scan */
chan deltas = [2] of { byte, byte, byte };             /* scan, epoch, version */
chan mapped = [2] of { byte };                         /* scan: the same to the publisher, or an answer to a match */
chan requests = [2] of { byte, byte, byte, byte, byte }; /* requester, question, epoch, base version, first tile */
/* The request; epoch, version, next tile, scans of the version as bits; the tile of the page and its content. */
chan pages = [2] of { byte, byte, byte, byte, byte, byte, byte, byte, byte, byte, byte };

byte losses = LOSSES, doubles = DOUBLES, kills = KILLS, power_cuts = POWER_CUTS, forged = FORGED;
bool done = false;

/* The owner's map, and what it was at each version of each epoch. */
byte epoch = 0, version = 0, scans = 0, last = 0, held = 0;
byte content[2 * VERSIONS * TILES];

/* What waits for an answer is sent again by a clock, which goes on when no message is on its way. */
#define IS_QUIET                                                                                    \
  (empty(rays_to_matcher) && empty(rays_to_owner) && empty(matches) && empty(deltas) && empty(mapped) && \
   empty(requests) && empty(pages))
bool publisher_is_due = false, matcher_is_due = false;
active proctype Clock() {
  do
  :: atomic { IS_QUIET && !publisher_is_due && !matcher_is_due && !done -> publisher_is_due = true; matcher_is_due = true }
  :: done -> break
  od
}

#define SEND(channel, message)                                        \
  if                                                                  \
  :: full(channel) -> skip                                            \
  :: nfull(channel) -> channel!message                                \
  :: losses > 0 -> losses--                                           \
  :: doubles > 0 && empty(channel) -> doubles--; channel!message; channel!message \
  fi

#define COMMA ,

active proctype Publisher() {
  byte scan = 1, heard;
send:
  atomic { SEND(rays_to_matcher, scan) };
  atomic { SEND(rays_to_owner, scan) };
wait:
  if
  :: atomic { mapped?heard ->
       if
       :: heard == scan && scan < SCANS -> scan++; goto send
       :: heard == scan && scan == SCANS -> done = true; goto end
       :: else -> goto wait
       fi }
  :: atomic { publisher_is_due -> publisher_is_due = false; goto send }
  fi;
end:
  skip
}

active proctype Owner() {
  byte scan, requester, question, of_epoch, base, first, tile, next, i;
  do
  :: done -> break
  :: atomic { rays_to_owner?scan -> held = scan }
  :: atomic { matches?scan ->
       if
       :: scan == last -> SEND(deltas, scan COMMA epoch COMMA version); SEND(mapped, scan)
       :: scan != last && (scans & (1 << scan)) != 0 -> SEND(mapped, scan)
       :: scan != last && (scans & (1 << scan)) == 0 && held != scan -> skip /* both will come again */
       :: scan != last && (scans & (1 << scan)) == 0 && held == scan ->
            assert(scan > last && version < SCANS);
            for (i : 0 .. TILES - 1) { content[TILE(epoch, version + 1, i)] = content[TILE(epoch, version, i)] };
            version++;
            last = scan;
            scans = scans | (1 << scan);
            if
            :: content[TILE(epoch, version, 0)] = version
            :: content[TILE(epoch, version, 1)] = version
            :: content[TILE(epoch, version, 0)] = version; content[TILE(epoch, version, 1)] = version
            fi;
            SEND(deltas, scan COMMA epoch COMMA version);
            SEND(mapped, scan)
       fi;
       scan = 0 }
  :: atomic { requests?requester, question, of_epoch, base, first ->
       /* Of another map all is told, from the start. */
       tile = (of_epoch == epoch + 1 -> first : 0);
       i = (of_epoch == epoch + 1 -> base : 0);
       do
       :: tile < TILES && content[TILE(epoch, version, tile)] <= i -> tile++
       :: else -> break
       od;
       next = tile + 1;
       do
       :: next < TILES && content[TILE(epoch, version, next)] <= i -> next++
       :: else -> break
       od;
       i = (tile < TILES -> content[TILE(epoch, version, tile)] : 0);
       tile = (tile < TILES -> tile : NONE);
       next = (next < TILES -> next : NONE);
       SEND(pages, requester COMMA question COMMA of_epoch COMMA base COMMA first COMMA epoch COMMA version COMMA next COMMA scans COMMA tile COMMA i);
       requester = 0; question = 0; of_epoch = 0; base = 0; first = 0; tile = 0; next = 0; i = 0 }
  :: atomic { kills > 0 && !done -> kills--; held = 0 }
  :: atomic { power_cuts > 0 && version > 0 && !done -> /* from here on it is another map, with an epoch of its own */
       power_cuts--;
       for (i : 0 .. (version - 1) * TILES + TILES - 1) { content[TILE(epoch + 1, 0, i)] = content[TILE(epoch, 0, i)] };
#ifndef BREAK_EPOCH /* else the same numbers are another map */
       epoch++;
#endif
       version--;
       scans = scans & (~(1 << last));
       last = 0;
       for (i : 1 .. SCANS) { if :: (scans & (1 << i)) != 0 -> last = i :: else -> skip fi };
       held = 0; i = 0 }
  od
}

/* The matcher's replica. Its epochs are one more than the owner's: 0 is none. */
byte have[TILES];
byte r_epoch = 0, r_version = 0, r_first = 0, r_scans = 0, r_last = 0, heard_version = 0, pages_version = NONE;
byte sent = 0; /* the last match */
bool has_doubted = false;
byte waiting = 0; /* a scan that cannot be matched yet */
bool synced = false, whole = false;
byte question_now = 0, asked_epoch = NONE, asked_base = NONE, asked_first = NONE, requester_now = 1;

#define BEGIN(new_epoch)                                                               \
  r_epoch = new_epoch; r_version = 0; r_first = 0; r_scans = 0; r_last = 0;             \
  heard_version = 0; pages_version = NONE; synced = false; whole = false; sent = 0;    \
  has_doubted = false;                                                                 \
  have[0] = 0; have[1] = 0

/* A question that is new goes out at once. In the code one that is asked again, because an update was requested, has a new
 * number, too. Here that would be states without end: answers to the earlier one are taken, which the code leaves out. */
#define ASK                                                                                                      \
  if                                                                                                             \
  :: !synced && (asked_epoch != r_epoch || asked_base != r_version || asked_first != r_first) ->                 \
       question_now++;                                                                                           \
       asked_epoch = r_epoch; asked_base = r_version; asked_first = r_first;                                     \
       SEND(requests, requester_now COMMA question_now COMMA r_epoch COMMA r_version COMMA r_first)              \
  :: else -> skip                                                                                                \
  fi

#define IS_ANSWERED (sent == 0 || (r_scans & (1 << sent)) != 0)

/* A scan that came again gets its answer again. Another one is matched when the map of the last match is here, or the
 * owner, asked since, does not know of that match any more. */
#define MATCH                                                                                                    \
  if                                                                                                             \
  :: waiting != 0 && (waiting == sent || (r_scans & (1 << waiting)) != 0) -> SEND(matches, waiting); waiting = 0 \
  :: waiting != 0 && waiting != sent && (r_scans & (1 << waiting)) == 0 && synced && (IS_ANSWERED || has_doubted) -> \
       sent = waiting; has_doubted = false; SEND(matches, waiting); waiting = 0                                  \
  :: else -> skip                                                                                                \
  fi

#define IS_WHOLE                                                                       \
  (have[0] == content[TILE(r_epoch - 1, r_version, 0)] && have[1] == content[TILE(r_epoch - 1, r_version, 1)])

#ifdef BREAK_WHOLE
#define IS_BASE true
#else
#define IS_BASE whole
#endif

/* A page is taken if it answers the question that was asked last, and that is still the question. */
#ifdef BREAK_ANSWERS /* as if a page did not say what it answers */
#define IS_ANSWER true
#else
#define IS_ANSWER                                                                                                  \
  (q == question_now && q_epoch == asked_epoch && q_base == asked_base && q_first == asked_first &&               \
   q_epoch == r_epoch && q_base == r_version && q_first == r_first)
#endif

active proctype Matcher() {
  byte scan, e, v, next, of_scans, tile, x, q, q_requester, q_epoch, q_base, q_first;
  atomic { ASK };
  do
  :: done -> break
  :: atomic { matcher_is_due ->
       matcher_is_due = false;
       if
       :: !synced -> SEND(requests, requester_now COMMA question_now COMMA r_epoch COMMA r_version COMMA r_first)
       :: synced && waiting != 0 && !IS_ANSWERED -> synced = false; has_doubted = true; ASK
       :: else -> skip
       fi }
  :: atomic { rays_to_matcher?scan -> waiting = scan; MATCH; scan = 0 }
  :: atomic { deltas?scan, e, v ->
       if
       :: e + 1 != r_epoch -> synced = false
       :: e + 1 == r_epoch && v == r_version && synced ->
            if
            :: scan != r_last -> BEGIN(r_epoch)
            :: else -> skip
            fi
       :: e + 1 == r_epoch && !(v == r_version && synced) ->
            heard_version = (v > heard_version -> v : heard_version);
            if
            :: v != r_version + 1 -> synced = false
#ifndef BREAK_WHOLE /* else a delta is put onto half a version */
            :: v == r_version + 1 && !whole -> skip
#endif
            :: v == r_version + 1 && IS_BASE && scan != sent -> synced = false
            :: v == r_version + 1 && IS_BASE && scan == sent ->
                 for (x : 0 .. TILES - 1) {
                   if
                   :: content[TILE(e, v, x)] == v ->
                        have[x] = (have[x] == content[TILE(e, v - 1, x)] -> v : WRONG)
                   :: else -> skip
                   fi
                 };
                 r_version++;
                 r_scans = r_scans | (1 << scan);
                 r_last = scan;
                 synced = r_version >= heard_version;
                 assert(!synced || IS_WHOLE)
            fi
       fi;
       ASK;
       MATCH;
       scan = 0; e = 0; v = 0; x = 0 }
  :: atomic { pages?q_requester, q, q_epoch, q_base, q_first, e, v, next, of_scans, tile, x ->
       if
       :: !synced && q_requester == requester_now && IS_ANSWER ->
            if
            :: e + 1 != r_epoch -> BEGIN(e + 1)
            :: else -> skip
            fi;
            if
            :: v < r_version || (pages_version != NONE && v < pages_version) -> BEGIN(r_epoch)
            :: else ->
                 pages_version = (pages_version == NONE -> v : pages_version);
                 whole = false;
                 if
                 :: tile != NONE -> have[tile] = x
                 :: else -> skip
                 fi;
                 if
                 :: next != NONE -> r_first = next
                 :: next == NONE ->
                      r_scans = of_scans;
                      r_last = 0;
                      for (x : 1 .. SCANS) { if :: (r_scans & (1 << x)) != 0 -> r_last = x :: else -> skip fi };
                      r_version = pages_version;
                      pages_version = NONE;
                      r_first = 0;
                      whole = r_version == v;
                      synced = whole;
                      assert(!synced || IS_WHOLE)
                 fi
            fi
       :: else -> skip
       fi;
       ASK;
       MATCH;
       q_requester = 0; q = 0; q_epoch = 0; q_base = 0; q_first = 0; e = 0; v = 0; next = 0; of_scans = 0; tile = 0; x = 0 }
  :: atomic { kills > 0 && !done -> /* a new process knows nothing */
       kills--;
       BEGIN(0);
       requester_now++; question_now = 0; asked_epoch = NONE; asked_base = NONE; asked_first = NONE;
       ASK }
  od
}

/* Anybody may ask in the matcher's name: with the number of its question, or of the next one. */
active proctype Forger() {
  byte ask_version, ask_first, number;
  do
  :: atomic { forged > 0 && !done && nfull(requests) ->
       forged--;
       if :: ask_version = 0 :: ask_version = SCANS fi; /* all that there is, or nothing */
       if :: ask_first = 0 :: ask_first = 1 fi;
       if :: number = 0 :: number = 1 fi;
       requests!requester_now, question_now + number, r_epoch, ask_version, ask_first;
       ask_version = 0; ask_first = 0; number = 0 }
  :: forged == 0 || done -> break
  od
}

/* In the end all scans were answered. */
ltl answered { <> done }
