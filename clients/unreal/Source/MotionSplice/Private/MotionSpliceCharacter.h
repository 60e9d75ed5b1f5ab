// A character in Unreal's axes: a bank, what it plays of it, and the moment.
#pragma once

#include "CoreMinimal.h"
#include "MotionSpliceEvaluator.h"
#include "Templates/UniquePtr.h"

struct FMotionSplicePlayback;

/** One character of a bank. Knows neither Live Link nor a clock. Use it from one thread at a time. */
class FMotionSpliceCharacter
{
public:
	/** Opens the bank in a folder. If it is missing or damaged, returns null and fills in Error. */
	static TUniquePtr<FMotionSpliceCharacter> Open(const FString& Folder, FString& Error);

	explicit FMotionSpliceCharacter(motionsplice::Bank&& InBank);
	FMotionSpliceCharacter(const FMotionSpliceCharacter&) = delete; // the evaluator holds the bank's address

	TArray<FName> BoneNames() const;
	TArray<int32> BoneParents() const; // -1 for bone 0

	/** Plays other clips. Another locomotion begins at its first frame, where the character stands.
	    Returns an error message if the bank does not have them, else an empty string. */
	FString Play(const FMotionSplicePlayback& Playback);

	/** Advances by some seconds. A clip without a loop begins again at its end. */
	void Advance(double Seconds);

	/** Writes a transform for each bone, in its parent's frame, in Unreal's axes and centimetres.
	    Returns an error message, or an empty string. */
	FString Evaluate(TArray<FTransform>& Transforms);

private:
	void Move(double Seconds);

	const motionsplice::Bank Bank;
	motionsplice::Evaluator Evaluator;
	motionsplice::Splice Splice;
	motionsplice::Memory Memory;
	motionsplice::Place Place;
	double Time = 0.0; // seconds into the locomotion
	bool bInPlace = false;
	TArray<float> Rotations;
};
