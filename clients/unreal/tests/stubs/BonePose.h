#pragma once
#include "CoreMinimal.h"

/** Index into all bones of a mesh. */
struct FMeshPoseBoneIndex
{
	int32 BoneIndex;

	explicit FMeshPoseBoneIndex(int32 InBoneIndex) : BoneIndex(InBoneIndex) {}
};

/** Index into the bones that a level of detail needs; here all. */
struct FCompactPoseBoneIndex
{
	explicit FCompactPoseBoneIndex(int32 InBoneIndex) : BoneIndex(InBoneIndex) {}
	int32 GetInt() const { return BoneIndex; }

private:
	int32 BoneIndex;
};

struct FBoneContainer
{
	TArray<FName> Names;
	TArray<int32> Parents;
	TArray<FTransform> RefPose;

	int32 GetPoseBoneIndexForBoneName(const FName& BoneName) const
	{
		for (int32 Bone = 0; Bone < Names.Num(); ++Bone)
		{
			if (Names[Bone] == BoneName)
			{
				return Bone;
			}
		}
		return INDEX_NONE;
	}
	FCompactPoseBoneIndex MakeCompactPoseIndex(const FMeshPoseBoneIndex& Bone) const
	{
		return FCompactPoseBoneIndex(Bone.BoneIndex);
	}
};

struct FCompactPose
{
	explicit FCompactPose(const FBoneContainer& InBones) : Bones(InBones), Transforms(InBones.RefPose) {}

	const FBoneContainer& GetBoneContainer() const { return Bones; }
	const FTransform& GetRefPose(const FCompactPoseBoneIndex& Bone) const { return Bones.RefPose[Bone.GetInt()]; }
	FCompactPoseBoneIndex GetParentBoneIndex(const FCompactPoseBoneIndex& Bone) const
	{
		return FCompactPoseBoneIndex(Bones.Parents[Bone.GetInt()]);
	}
	FTransform& operator[](const FCompactPoseBoneIndex& Bone) { return Transforms[Bone.GetInt()]; }
	std::vector<FCompactPoseBoneIndex> ForEachBoneIndex() const
	{
		std::vector<FCompactPoseBoneIndex> Indices;
		for (int32 Bone = 0; Bone < Bones.Parents.Num(); ++Bone)
		{
			Indices.push_back(FCompactPoseBoneIndex(Bone));
		}
		return Indices;
	}

private:
	const FBoneContainer& Bones;
	TArray<FTransform> Transforms;
};
